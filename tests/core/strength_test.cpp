#include "core/physics/strength.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/physics/contact_law.h"

namespace creep {
namespace {

TEST(Strength, limit_stress_follows_the_size_law_of_both_presets) {
  Material material;
  EXPECT_NEAR(limit_stress(material, 2e-3, 0.0), 3.75e9, 1.0);  // at the reference diameter
  EXPECT_NEAR(limit_stress(material, 0.21e-3, 0.0), 6.59e9, 0.005e9);
  material.size_exponent = 1.0 / 12.0;
  EXPECT_NEAR(limit_stress(material, 0.21e-3, 0.0), 4.525e9, 0.0005e9);
  material.reference_diameter = 0.1155e-3;
  EXPECT_NEAR(limit_stress(material, 0.21e-3, 0.0), 3.568e9, 0.0005e9);
}

TEST(Strength, scatter_is_normal_and_floored) {
  const Material material;
  const double mean = limit_stress(material, 0.3e-3, 0.0);
  EXPECT_NEAR(limit_stress(material, 0.3e-3, 1.5) / mean, 1.57, 1e-14);
  EXPECT_NEAR(limit_stress(material, 0.3e-3, -2.4) / mean, 0.088, 1e-14);
  EXPECT_NEAR(limit_stress(material, 0.3e-3, -2.6) / mean, 0.05, 1e-14);
  EXPECT_NEAR(limit_stress(material, 0.3e-3, -8.0) / mean, 0.05, 1e-14);
}

TEST(Strength, crushing_forces_of_an_equal_pair_match_the_independent_values) {
  // F = sigma_lim pi r' overlap on the rough law, solved by bisection; 0.21 mm and 0.378 mm, k = 1/12.
  const RoughLaw law = RoughLaw::make(0.6e-6, 0.05, 5.0);
  Material material;
  material.size_exponent = 1.0 / 12.0;
  const auto crushing_force = [&](double diameter, double reference) {
    material.reference_diameter = reference;
    const double strength = limit_stress(material, diameter, 0.0);
    const double reduced_radius = diameter / 4.0;
    const double factor = material.reduced_modulus() * std::sqrt(reduced_radius);
    double low = 1e-9, high = 1e-4;
    for (int i = 0; i < 200; ++i) {
      const double overlap = 0.5 * (low + high);
      (mobilised_stress(factor * law.g(overlap), reduced_radius, overlap) < strength ? low : high) = overlap;
    }
    return factor * law.g(low);
  };
  // Tolerances: half a unit of the last printed digit.
  EXPECT_NEAR(crushing_force(0.21e-3, 2e-3), 7.405, 0.0006);
  EXPECT_NEAR(crushing_force(0.21e-3, 0.21e-3), 4.908, 0.0006);
  EXPECT_NEAR(crushing_force(0.21e-3, 0.1155e-3), 4.402, 0.0006);
  EXPECT_NEAR(crushing_force(0.378e-3, 2e-3), 16.99, 0.006);
  EXPECT_NEAR(crushing_force(0.378e-3, 0.21e-3), 11.26, 0.006);
}

}  // namespace
}  // namespace creep
