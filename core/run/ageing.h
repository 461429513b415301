// The only place where laboratory age passes (section 2.3). Contact forces are frozen, so every crack has a
// constant velocity and the time to each failure is exact.
#pragma once

#include <cstdint>
#include <vector>

#include "core/dem/dynamics.h"
#include "core/dem/specimen.h"
#include "core/experiment/experiment.h"

namespace creep {

struct AgeingJump {
  double age = 0.0;               ///< that passed [s]
  std::vector<Failure> failures;  ///< ascending index: all whose crack reached the radius
  bool reached_end = false;       ///< the time left ran out before the wanted number failed
};

/// Advances age and every crack to the time at which `wanted` particles have failed, or by `time_left` if
/// that comes first. sigma_mob must be that of the present positions (Dynamics::assess). Particles that fail
/// at the same instant all break. @param wanted  n_age >= 1.
AgeingJump age(Specimen& specimen, const Material& material, std::int64_t wanted, double time_left);

/// n_age: the job's, or round(0.0026 x initial count), at least 1.
std::int64_t breakages_per_ageing(const Numerics& numerics, std::int64_t initial_count);

}  // namespace creep
