// Subcritical growth of the crack of a particle: Charles' law (eqs 14-21).
//
// At constant stress the crack grows at constant velocity, so the time to failure is exact and no integration
// scheme enters. A particle fails when its crack reaches its radius.
#pragma once

#include "core/experiment/experiment.h"

namespace creep {

/// Initial crack [m], uniform in (0.001 d, 0.5 d); `uniform` in (0, 1).
double initial_crack(double diameter, double uniform);

/// Crack velocity [m/s] (eq 20): v0 ratio^n, ratio = mobilised over limit stress >= 0. A whole n up to 1024,
/// such as 60, is done by repeated squaring (relative error about n x 1e-16, a tenth of the cost of the
/// general power).
double crack_velocity(const Material& material, double stress_ratio);

/// Time until the crack reaches the radius at constant velocity [s] (eq 21): 0 when it has, +inf without
/// growth.
double time_to_failure(double radius, double crack, double velocity);

}  // namespace creep
