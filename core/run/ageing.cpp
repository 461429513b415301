#include "core/run/ageing.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/arithmetic/elementary.h"
#include "core/physics/crack.h"

namespace creep {

namespace {

constexpr double kForever = std::numeric_limits<double>::infinity();

/// n: crack velocity [m/s] and time to failure [s] at the present stress.
struct FailureTimes {
  std::vector<double> velocity, time;
};

FailureTimes failure_times(const Particles& particles, const Material& material) {
  const std::size_t n = particles.size();
  FailureTimes all{std::vector<double>(n), std::vector<double>(n, kForever)};
  for (std::size_t i = 0; i < n; ++i) {
    if (particles.body[i].breaking_stress == kForever) continue;
    all.velocity[i] = crack_velocity(material, particles.mobilised_stress[i] / particles.limit_stress[i]);
    all.time[i] = time_to_failure(particles.body[i].radius, particles.crack[i], all.velocity[i]);
  }
  return all;
}

/// The wanted-th smallest; infinite beyond the last.
double nth_time(std::vector<double> times, std::int64_t wanted) {
  if (wanted > static_cast<std::int64_t>(times.size())) return kForever;
  const auto nth = times.begin() + static_cast<std::ptrdiff_t>(wanted - 1);
  std::nth_element(times.begin(), nth, times.end());
  return *nth;
}

}  // namespace

AgeingJump age(Specimen& specimen, const Material& material, std::int64_t wanted, double time_left) {
  Particles& particles = specimen.particles;
  const std::size_t n = particles.size();
  const auto [velocity, failure_age] = failure_times(particles, material);
  AgeingJump jump;
  jump.age = time_left;
  jump.reached_end = true;
  if (const double nth = nth_time(failure_age, wanted); nth < time_left) {
    jump.age = nth;
    jump.reached_end = false;
  }
  for (std::size_t i = 0; i < n; ++i) {
    if (failure_age[i] <= jump.age) {
      particles.crack[i] = particles.body[i].radius;
      jump.failures.push_back({static_cast<std::int32_t>(i), FailureCause::kCrackInAgeing,
                               particles.mobilised_stress[i] / particles.limit_stress[i]});
    } else {
      particles.crack[i] += velocity[i] * jump.age;
    }
  }
  specimen.clocks.age += jump.age;
  return jump;
}

double time_to_failures(const Specimen& specimen, const Material& material, std::int64_t wanted) {
  return nth_time(failure_times(specimen.particles, material).time, wanted);
}

double relative_strain_error(const AgeingError& error) {
  const double promised = log_end_of_ageing(error.after, error.promised, error.left);
  const double found = log_end_of_ageing(error.after, error.found, error.left);
  return 0.5 * std::fabs(found - promised) / elementary::log(error.after / error.before);
}

std::int64_t adapted_breakages(std::int64_t breakages, double error, double tolerance,
                               std::int64_t initial_count) {
  const std::int64_t most =
      std::max<std::int64_t>(1, std::llround(0.026 * static_cast<double>(initial_count)));
  const double factor = error > 0.0 ? std::clamp(tolerance / error, 0.5, 2.0) : 2.0;
  return std::clamp<std::int64_t>(std::llround(static_cast<double>(breakages) * factor), 1, most);
}

double log_end_of_ageing(double creep_time, double next, double left) {
  constexpr double kShortest = 1e-9;  // s: below the dynamic time of one cycle, so that there is a logarithm
  return elementary::log(std::max(kShortest, creep_time + std::min(next, left)));
}

}  // namespace creep
