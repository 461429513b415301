// Walls that hold a stress.
#pragma once

#include <array>

#include "core/dem/specimen.h"

namespace creep {

/// How the pair of walls of one axis moves.
struct AxisControl {
  enum class Mode { kFixed, kServo, kVelocity };
  Mode mode = Mode::kFixed;
  double stress = 0.0;            ///< target under servo, compression positive [Pa]
  double closing_velocity = 0.0;  ///< of the pair: cap under servo, else the speed itself [m/s]
};

using WallControl = std::array<AxisControl, 3>;

/// Sets the wall velocities for the next step from the forces of the last.
///
/// Both walls of a servo-controlled pair move alike, at
///   v = (target x area - mean wall force) / (c Z),   |v| <= closing_velocity / 2,
/// with Z = sqrt(M K) [kg/s] the mechanical impedance of the specimen, M its mass [kg] and K = (wall contact
/// stiffness) x d50 / length [N/m] its stiffness as layers of grains in series. c = 3 [-] makes the stress
/// error decay over about 1.5 times the period sqrt(M/K) in which the specimen itself can answer: faster
/// rings.
void steer(Walls& walls, const WallControl& control, double mass, double median_diameter);

}  // namespace creep
