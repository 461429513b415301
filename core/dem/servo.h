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
  bool follows = false;           ///< under servo: holds its stress also while its walls must go on moving
};

using WallControl = std::array<AxisControl, 3>;

/// steer() sets the wall velocities for the next step from the forces of the last.
///
/// Both walls of a servo-controlled pair move alike, at
///   v = (target x area - mean wall force) / (c Z),   |v| <= closing_velocity / 2,
/// with Z = sqrt(M K) [kg/s] the mechanical impedance of the specimen, M its mass [kg] and K = (wall contact
/// stiffness) x d50 / length [N/m] its stiffness as layers of grains in series. c = 3 [-] makes the stress
/// error decay over about 1.5 times the period T = sqrt(M/K) in which the specimen itself can answer: faster
/// rings.
///
/// A wall that has to go on moving at u, to let a sheared specimen spread, does so only at an error c Z u:
/// the stress lags. Where a pair `follows`, it has a velocity beside that of the error, `Walls::carried`,
/// which the error builds up until none is left, over k periods [-]:
///   v = carried + error / (c Z),
///   change of carried = error / (c Z) x step / (k T) = error x step / (c k M)   [N s/kg = m/s].
/// Both walls at v change the force by dF/dt = 2 K (v - u), so the error E obeys
///   E'' + 2/(c T) E' + 2/(c k T^2) E = 0,
/// damped critically at k = 2 c = 6: a step of u is met by an error of 2 K u t exp(-t / (c T)). With an
/// answer that is late by T it stays stable for all k > 1 (Routh). `carried` rests while the cap holds v, or
/// it would have to be undone afterwards.
struct ServoGains {
  double impedances = 3.0;  ///< c [-]
  double periods = 6.0;     ///< k [-]
};

/// @param step  until the next call [s]
void steer(Walls& walls, const WallControl& control, double mass, double median_diameter, double step,
           ServoGains gains = {});

}  // namespace creep
