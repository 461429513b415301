#include "core/physics/crack.h"

#include <limits>

#include "core/arithmetic/elementary.h"

namespace creep {
namespace {

constexpr double kGreatestWholePower = 1024.0;

/// x^n by repeated squaring.
double whole_power(double x, int n) {
  double power = 1.0;
  for (; n > 0; n >>= 1) {
    if (n & 1) power *= x;
    x *= x;
  }
  return power;
}

}  // namespace

double initial_crack(double diameter, double uniform) { return diameter * (0.001 + 0.499 * uniform); }

double crack_velocity(const Material& material, double stress_ratio) {
  const double n = material.corrosion_index;
  if (n >= 0.0 && n <= kGreatestWholePower) {
    const int whole = static_cast<int>(n);
    if (static_cast<double>(whole) == n) return material.crack_velocity * whole_power(stress_ratio, whole);
  }
  return material.crack_velocity * elementary::pow(stress_ratio, n);
}

double time_to_failure(double radius, double crack, double velocity) {
  if (crack >= radius) return 0.0;
  if (!(velocity > 0.0)) return std::numeric_limits<double>::infinity();
  return (radius - crack) / velocity;
}

}  // namespace creep
