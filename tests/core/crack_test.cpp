#include "core/physics/crack.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>

#include "core/arithmetic/elementary.h"

namespace creep {
namespace {

TEST(Crack, initial_length_covers_its_range) {
  EXPECT_NEAR(initial_crack(0.2e-3, 0.0), 0.0002e-3, 1e-18);
  EXPECT_NEAR(initial_crack(0.2e-3, 0.5), 0.0501e-3, 1e-18);
  EXPECT_NEAR(initial_crack(0.2e-3, 1.0), 0.1e-3, 1e-18);
}

TEST(Crack, stress_ratios_that_fail_after_given_times_match_the_independent_table) {
  struct Case {
    double diameter, stress_ratio, age;
  };
  constexpr double kDay = 86400.0;
  const std::array<Case, 10> cases = {{{0.21e-3, 0.9631, 10e-3},
                                       {0.21e-3, 0.9268, 0.1},
                                       {0.21e-3, 0.8331, 60.0},
                                       {0.21e-3, 0.8017, 600.0},
                                       {0.21e-3, 0.7650, 1e4},
                                       {0.21e-3, 0.7380, kDay},
                                       {0.21e-3, 0.7295, 2.0 * kDay},
                                       {0.21e-3, 0.6689, 365.25 * kDay},
                                       {0.12e-3, 0.7312, kDay},
                                       {0.40e-3, 0.7460, kDay}}};
  const Material material;
  for (const auto& [diameter, ratio, age] : cases) {
    const double velocity = crack_velocity(material, ratio);
    // Half a unit of the fourth digit of the ratio, to the power 60, is 0.5 %.
    EXPECT_NEAR(time_to_failure(0.5 * diameter, 0.001 * diameter, velocity) / age, 1.0, 0.005) << ratio;
  }
}

TEST(Crack, whole_exponents_agree_with_the_general_power) {
  Material material;
  for (const double n : {1.0, 2.0, 34.0, 60.0, 61.0}) {
    material.corrosion_index = n;
    const double expected = 0.1 * elementary::pow(0.83, n);
    EXPECT_NEAR(crack_velocity(material, 0.83) / expected, 1.0, 2e-16 * (n + 10.0)) << n;  // n roundings
  }
  material.corrosion_index = 33.5;
  EXPECT_NEAR(crack_velocity(material, 0.83) / (0.1 * elementary::pow(0.83, 33.5)), 1.0, 1e-15);
}

TEST(Crack, an_unloaded_particle_never_fails_and_a_cracked_one_has_failed) {
  const Material material;
  EXPECT_EQ(crack_velocity(material, 0.0), 0.0);
  EXPECT_EQ(time_to_failure(1e-4, 1e-6, 0.0), std::numeric_limits<double>::infinity());
  EXPECT_EQ(time_to_failure(1e-4, 1e-4, 0.0), 0.0);
  EXPECT_EQ(time_to_failure(1e-4, 2e-4, 1.0), 0.0);
}

TEST(Crack, time_to_failure_does_not_depend_on_how_the_growth_is_cut_into_steps) {
  const Material material;
  const double radius = 0.105e-3, velocity = crack_velocity(material, 0.8);
  double crack = 0.02e-3, elapsed = 0.0;
  const double whole = time_to_failure(radius, crack, velocity);
  for (int i = 0; i < 1000; ++i) {
    const double step = whole / 2000.0;
    crack += velocity * step;
    elapsed += step;
  }
  EXPECT_NEAR((elapsed + time_to_failure(radius, crack, velocity)) / whole, 1.0, 1e-12);  // 1000 roundings
}

}  // namespace
}  // namespace creep
