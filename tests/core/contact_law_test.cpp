#include "core/physics/contact_law.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "core/experiment/experiment.h"

namespace creep {
namespace {

constexpr double kRoughness = 0.6e-6;
constexpr double kReducedRadius = 52.5e-6;  // of two grains of 0.21 mm

RoughLaw fontainebleau() { return RoughLaw::make(kRoughness, 0.05, 5.0); }

/// E' sqrt(r') of two grains of 0.21 mm [Pa m^0.5].
double pair_factor() { return Material{}.reduced_modulus() * std::sqrt(kReducedRadius); }

TEST(ContactLaw, closure_gives_the_constants_of_fontainebleau_sand) {
  const RoughLaw law = fontainebleau();
  // Tolerances: half a unit of the last digit of the independently computed constants.
  EXPECT_NEAR(law.b(), 1.8347165, 0.5e-7);
  EXPECT_NEAR(law.c(), 1.8759038, 0.5e-7);
  EXPECT_NEAR(law.delta_T1() / kRoughness, 2.2772819, 1e-7);
  EXPECT_NEAR(law.delta_T2() / kRoughness, 27.457, 0.5e-3);
  const double factor = pair_factor();
  EXPECT_NEAR(factor * law.g(law.delta_T1()), 0.188142, 0.5e-6);
  EXPECT_NEAR(factor * law.g(law.delta_T2()), 18.8142, 0.5e-4);
  EXPECT_NEAR(factor * law.slope(law.delta_T1()), 258302.7, 0.1);
  // By hand from the Hertz branch: 1.5 x 18.8142 N over a depth of 22.407 S_q.
  EXPECT_NEAR(factor * law.slope(law.delta_T2()), 2099144.0, 50.0);
}

TEST(ContactLaw, thresholds_scale_with_the_roughness) {
  const RoughLaw one = fontainebleau();
  const RoughLaw two = RoughLaw::make(2.0 * kRoughness, 0.05, 5.0);
  EXPECT_NEAR(two.delta_T1() / one.delta_T1(), 2.0, 1e-14);  // rounding
  EXPECT_NEAR(two.delta_T2() / one.delta_T2(), 2.0, 1e-14);
  EXPECT_NEAR(two.b(), one.b(), 1e-14);
}

TEST(ContactLaw, force_and_stiffness_are_continuous_at_both_thresholds) {
  for (const auto& [n1, n2] : {std::array{0.05, 5.0}, std::array{0.82, 1.24}}) {
    const RoughLaw law = RoughLaw::make(kRoughness, n1, n2);
    for (const double threshold : {law.delta_T1(), law.delta_T2()}) {
      const double below = threshold * (1.0 - 1e-12);
      const double above = threshold * (1.0 + 1e-12);
      EXPECT_NEAR(law.g(above) / law.g(below), 1.0, 1e-11);  // 2e-12 apart, times the exponent
      EXPECT_NEAR(law.slope(above) / law.slope(below), 1.0, 1e-11);
    }
  }
}

TEST(ContactLaw, slope_is_the_derivative_of_the_force) {
  const RoughLaw law = fontainebleau();
  for (double x = 0.01; x < 60.0; x *= 1.3) {
    const double overlap = x * kRoughness, step = 1e-4 * overlap;
    if (std::fabs(overlap - law.delta_T1()) < step || std::fabs(overlap - law.delta_T2()) < step) continue;
    const double numeric = (law.g(overlap + step) - law.g(overlap - step)) / (2.0 * step);
    EXPECT_NEAR(numeric / law.slope(overlap), 1.0, 1e-8) << x;  // step^2/6 g'''/g'
  }
}

TEST(ContactLaw, without_roughness_it_is_hertz) {
  const RoughLaw law = RoughLaw::make(0.0, 0.05, 5.0);
  const LawTable table(law);
  for (const double overlap : {1e-12, 1e-9, 3e-7, 1e-5}) {
    const double hertz = 4.0 / 3.0 * std::pow(overlap, 1.5);
    EXPECT_NEAR(law.g(overlap) / hertz, 1.0, 1e-14);
    EXPECT_NEAR(law.slope(overlap) / (1.5 * hertz / overlap), 1.0, 1e-14);
    EXPECT_NEAR(law.energy(overlap) / (0.4 * hertz * overlap), 1.0, 1e-14);
    double g = 0.0, slope = 0.0;
    table.evaluate(overlap, g, slope);
    EXPECT_NEAR(g / hertz, 1.0, 1e-14);
    EXPECT_NEAR(slope / (1.5 * hertz / overlap), 1.0, 1e-14);
  }
}

TEST(ContactLaw, energy_is_the_integral_of_the_force_in_all_branches) {
  const RoughLaw law = fontainebleau();
  for (const double x : {0.3, 2.0, 2.2772819, 5.0, 20.0, 27.457, 45.0}) {
    // Simpson with overlap = end s^2, branch by branch: the force is smooth inside each.
    const double end = x * kRoughness;
    double integral = 0.0;
    const std::array<double, 4> limits = {0.0, std::min(end, law.delta_T1()), std::min(end, law.delta_T2()),
                                          end};
    for (std::size_t k = 0; k + 1 < limits.size(); ++k) {
      const double s0 = std::sqrt(limits[k] / end), s1 = std::sqrt(limits[k + 1] / end);
      constexpr int kIntervals = 2000;
      for (int i = 0; i <= kIntervals; ++i) {
        const double s = s0 + (s1 - s0) * i / kIntervals;
        const double weight = (i == 0 || i == kIntervals) ? 1.0 : (i % 2 == 1 ? 4.0 : 2.0);
        integral += weight * law.g(end * s * s) * 2.0 * end * s * (s1 - s0) / (3.0 * kIntervals);
      }
    }
    EXPECT_NEAR(law.energy(end) / integral, 1.0, 1e-10) << x;  // Simpson's error
  }
}

/// Worst relative errors of the table against the exact law, from 1e-3 to 40 S_q and at the knots.
void expect_table_follows(const RoughLaw& law) {
  const LawTable table(law);
  double worst_g = 0.0, worst_slope = 0.0;
  const auto compare = [&](double overlap) {
    double g = 0.0, slope = 0.0;
    table.evaluate(overlap, g, slope);
    worst_g = std::max(worst_g, std::fabs(g / law.g(overlap) - 1.0));
    worst_slope = std::max(worst_slope, std::fabs(slope / law.slope(overlap) - 1.0));
  };
  for (double x = 1e-3; x < 40.0; x *= 1.0001) compare(x * kRoughness);  // tens of points in each cell
  for (const double knot : {law.delta_T1(), law.delta_T2()}) {
    compare(knot);
    compare(std::nextafter(knot, 0.0));
    compare(std::nextafter(knot, 1.0));
  }
  EXPECT_LE(worst_g, 1e-9);
  EXPECT_LE(worst_slope, 1e-9);
}

TEST(LawTable, follows_the_law_to_1e_9_in_force_and_stiffness) {
  expect_table_follows(fontainebleau());
  expect_table_follows(RoughLaw::make(kRoughness, 0.82, 1.24));  // Otsubo's own coefficients
  expect_table_follows(RoughLaw::make(kRoughness, 0.0, 0.0));
  expect_table_follows(RoughLaw::make(kRoughness, 10.0, 0.0));
}

TEST(LawTable, is_small_for_the_default_material) {
  const LawTable table(fontainebleau());
  EXPECT_EQ(table.cell_bits(), 7);
  EXPECT_LT(table.cell_count() * 32, 100 * 1024);  // bytes: a fraction of the second-level cache
  EXPECT_EQ(reinterpret_cast<std::uintptr_t>(table.cells()) % 32, 0u);
}

TEST(LawTable, has_the_cells_that_its_header_spells_out) {
  const LawTable table(fontainebleau());
  const auto cell_of = [&](double u) {
    return static_cast<std::int64_t>(std::bit_cast<std::uint64_t>(u) >> table.cell_shift()) -
           table.before_first_cell();
  };
  EXPECT_EQ(cell_of(LawTable::kFirstBorder), 1);
  EXPECT_EQ(cell_of(std::nextafter(LawTable::kFirstBorder, 0.0)), 0);
  EXPECT_EQ(cell_of(1.0), 1 + 20 * 128);
  EXPECT_EQ(cell_of(std::nextafter(1.0, 0.0)), 20 * 128);
  EXPECT_EQ(cell_of(std::nextafter(table.delta_T2(), 0.0) * table.inverse_delta_T1()),
            table.cell_count() - 1);
}

TEST(LawTable, is_continuous_and_monotonic_from_zero_overlap_on) {
  const RoughLaw law = fontainebleau();
  const LawTable table(law);
  double g = 1.0, slope = 1.0;
  table.evaluate(0.0, g, slope);
  EXPECT_EQ(g, 0.0);
  EXPECT_EQ(slope, 0.0);
  double previous = 0.0;
  for (double overlap = 1e-15; overlap < 40.0 * kRoughness; overlap *= 1.01) {
    table.evaluate(overlap, g, slope);
    EXPECT_GT(g, previous);
    EXPECT_GT(slope, 0.0);
    previous = g;
  }
  // Across every border between cells: the steps expected of one double, or rounding.
  for (std::int64_t cell = 1; cell < table.cell_count(); ++cell) {
    const double border = std::bit_cast<double>(static_cast<std::uint64_t>(table.before_first_cell() + cell)
                                                << table.cell_shift());
    double g_below = 0.0, slope_below = 0.0;
    table.evaluate(border * (1.0 - 0x1p-50) * law.delta_T1(), g_below, slope_below);
    table.evaluate(border * (1.0 + 0x1p-50) * law.delta_T1(), g, slope);
    ASSERT_NEAR(g / g_below, 1.0, 1e-13) << cell;
    if (cell > 1) {
      ASSERT_NEAR(slope / slope_below, 1.0, 1e-12) << cell;
    }
  }
}

/// Two equal grains approach head on; the relative motion is integrated with Runge-Kutta until they part.
struct Collision {
  double max_overlap = 0.0;
  double max_force = 0.0;
  double duration = 0.0;
};

Collision collide(const LawTable& table, double relative_velocity, double time_step) {
  const double reduced_mass = 0.5 * 1.284998e-8;  // of two grains of 0.21 mm, 2650 kg/m3
  const double factor = pair_factor();
  const auto acceleration = [&](double overlap) {
    double g = 0.0, slope = 0.0;
    if (overlap > 0.0) table.evaluate(overlap, g, slope);
    return -factor * g / reduced_mass;
  };
  Collision result;
  double overlap = 0.0, velocity = relative_velocity, elapsed = 0.0;
  while (elapsed == 0.0 || overlap > 0.0) {
    const double h = time_step;
    const double v1 = velocity, a1 = acceleration(overlap);
    const double v2 = velocity + 0.5 * h * a1, a2 = acceleration(overlap + 0.5 * h * v1);
    const double v3 = velocity + 0.5 * h * a2, a3 = acceleration(overlap + 0.5 * h * v2);
    const double v4 = velocity + h * a3, a4 = acceleration(overlap + h * v3);
    overlap += h / 6.0 * (v1 + 2.0 * v2 + 2.0 * v3 + v4);
    velocity += h / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4);
    elapsed += h;
    if (overlap > result.max_overlap) {
      result.max_overlap = overlap;
      result.max_force = -acceleration(overlap) * reduced_mass;
    }
  }
  result.duration = elapsed + overlap / std::fabs(velocity);  // back to the crossing
  return result;
}

TEST(ContactLaw, rough_head_on_collisions_match_the_independent_solution) {
  struct Case {
    double velocity, max_overlap, max_force, duration;
  };
  const std::array<Case, 4> cases = {{{0.1, 0.0866721e-6, 1.06595e-3, 2.457e-6},
                                      {1.0, 0.429846e-6, 0.0214933, 1.21854e-6},
                                      {10.0, 2.13268e-6, 0.432158, 0.604851e-6},
                                      {50.0, 6.57997e-6, 3.47548, 0.373969e-6}}};
  const RoughLaw law = fontainebleau();
  const LawTable table(law);
  for (const auto& [velocity, max_overlap, max_force, duration] : cases) {
    const Collision collision = collide(table, velocity, duration / 5000.0);
    // Six printed digits; the step leaves a relative 1e-7 at the turning point. The slowest duration has four
    // digits.
    EXPECT_NEAR(collision.max_overlap / max_overlap, 1.0, 5e-6) << velocity;
    EXPECT_NEAR(collision.max_force / max_force, 1.0, 5e-6) << velocity;
    EXPECT_NEAR(collision.duration / duration, 1.0, velocity < 0.5 ? 3e-4 : 5e-6) << velocity;
    // All kinetic energy is elastic at the turning point.
    const double kinetic = 0.25 * 1.284998e-8 * velocity * velocity;
    EXPECT_NEAR(pair_factor() * law.energy(collision.max_overlap) / kinetic, 1.0, 1e-6) << velocity;
  }
}

}  // namespace
}  // namespace creep
