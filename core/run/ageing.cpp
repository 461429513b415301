#include "core/run/ageing.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/physics/crack.h"

namespace creep {

AgeingJump age(Specimen& specimen, const Material& material, std::int64_t wanted, double time_left) {
  Particles& particles = specimen.particles;
  const std::size_t n = particles.size();
  std::vector<double> velocity(n), failure_age(n);
  for (std::size_t i = 0; i < n; ++i) {
    const bool can_fail = particles.body[i].breaking_stress != std::numeric_limits<double>::infinity();
    velocity[i] =
        can_fail ? crack_velocity(material, particles.mobilised_stress[i] / particles.limit_stress[i]) : 0.0;
    failure_age[i] = time_to_failure(particles.body[i].radius, particles.crack[i], velocity[i]);
    if (!can_fail) failure_age[i] = std::numeric_limits<double>::infinity();
  }
  AgeingJump jump;
  jump.age = time_left;
  jump.reached_end = true;
  if (static_cast<std::size_t>(wanted) <= n) {
    std::vector<double> ordered = failure_age;
    const auto nth = ordered.begin() + static_cast<std::ptrdiff_t>(wanted - 1);
    std::nth_element(ordered.begin(), nth, ordered.end());
    if (*nth < time_left) {
      jump.age = *nth;
      jump.reached_end = false;
    }
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

std::int64_t breakages_per_ageing(const Numerics& numerics, std::int64_t initial_count) {
  if (numerics.breakages_per_ageing) return *numerics.breakages_per_ageing;
  return std::max<std::int64_t>(1, std::llround(0.0026 * static_cast<double>(initial_count)));
}

}  // namespace creep
