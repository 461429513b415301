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

/// Laboratory time at present stresses until `wanted` particles have failed [s]; infinite if fewer can.
/// sigma_mob as for age().
double time_to_failures(const Specimen& specimen, const Material& material, std::int64_t wanted);

/// An estimate of n_age from the ageing before, which froze the forces although each failure changes them.
///
/// A jump of n failures from creep_time T0 to T promises, by the forces frozen at T0, that n more fail within
/// `promised` [s]; after its dynamic stage the forces of T say `found` [s]. Both are ends of the next jump,
///   d = |ln(T + found) - ln(T + promised)|,
/// by which one explicit step misjudges the path in ln creep_time; half of it is the error of taking the rate
/// of its beginning for that of the whole step (Heun against Euler). Creep strain goes with ln creep_time, so
/// the error of the strain of a decade, relative to that strain, is that of the step over its length,
///   E = d / 2 / ln(T / T0)  [-].
/// d grows with n^2 and ln(T / T0) with n: E is proportional to n, and n tolerance / E meets the tolerance.
/// One n is one noisy draw of failure times, so n changes by no more than a factor of 2 at once.
struct AgeingError {
  double before = 0.0;    ///< T0 [s]
  double after = 0.0;     ///< T [s]
  double promised = 0.0;  ///< [s]
  double found = 0.0;     ///< [s]
  double left = 0.0;      ///< until the end of the hold: later failures do not matter [s]
};
double relative_strain_error(const AgeingError& error);

/// n_age for the next jump, at least 1 and at most a tenfold of the paper's 0.26 % of the initial count.
std::int64_t adapted_breakages(std::int64_t breakages, double error, double tolerance,
                               std::int64_t initial_count);

/// ln of the creep_time at which the next ageing ends [-], time_to_failures() being `next` [s]: strain goes
/// with it, so its change over a window, times the creep strain of an e-fold of creep_time, is the error of
/// ending the dynamic stage now. A velocity goes with sigma_mob^n: a change of 0.06 is 0.1 % of sigma_mob.
double log_end_of_ageing(double creep_time, double next, double left);

}  // namespace creep
