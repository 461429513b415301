// When a particle breaks at once (eqs 10-12).
#pragma once

#include "core/experiment/experiment.h"

namespace creep {

/// Limit stress of one particle [Pa] (eq 11): sigma_lim0 (d/d0)^-k (1 + var X), with 1 + var X not below the
/// floor. diameter > 0 [m]; standard_normal is X [-].
double limit_stress(const Material& material, double diameter, double standard_normal);

/// Mobilised stress of one contact [Pa] (eq 12): the force over pi r' overlap, the area of a smooth elastic
/// contact. force [N], reduced_radius [m] and overlap [m] > 0. A particle's mobilised stress is the largest
/// of its contacts.
inline double mobilised_stress(double force, double reduced_radius, double overlap) {
  constexpr double kPi = 3.141592653589793;
  return force / ((kPi * reduced_radius) * overlap);
}

}  // namespace creep
