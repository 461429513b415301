#include "core/physics/grading.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace creep {
namespace {

constexpr double kPi = 3.141592653589793;

const Grading kFontainebleau = LognormalGrading{};

Grading three_segments() {
  return GradingPoints{{{0.08e-3, 0.0}, {0.15e-3, 0.1}, {0.25e-3, 0.7}, {0.40e-3, 1.0}}};
}

/// Share of the mass of the particles finer than the diameter.
double sampled_passing(const std::vector<double>& diameters, double diameter) {
  double finer = 0.0, all = 0.0;
  for (const double d : diameters) {
    all += d * d * d;
    if (d < diameter) finer += d * d * d;
  }
  return finer / all;
}

double mean_cube(const std::vector<double>& diameters) {
  double sum = 0.0;
  for (const double d : diameters) sum += d * d * d;
  return sum / static_cast<double>(diameters.size());
}

TEST(Grading, fontainebleau_particles_have_the_known_mean_volume_and_fill_the_cube) {
  const std::vector<double> diameters = stratified_diameters(kFontainebleau, 11500);
  ASSERT_EQ(diameters.size(), 11500u);
  // By numerical quadrature of the cut lognormal. (4 mm, 11 500 and 0.65 together would need 0.18607 mm.)
  EXPECT_NEAR(std::cbrt(mean_cube(diameters)), 0.18841e-3, 0.5e-8);
  EXPECT_NEAR(std::cbrt(mean_cubed_diameter(kFontainebleau)), 0.18841e-3, 0.5e-8);
  const double solid = 11500.0 * kPi / 6.0 * mean_cube(diameters);
  EXPECT_NEAR(std::cbrt(solid * 1.65), 4.0504e-3, 0.0002e-3);  // at a void ratio of 0.65
}

TEST(Grading, particles_reproduce_the_curve_by_mass) {
  for (const Grading& grading : {kFontainebleau, three_segments()}) {
    const std::vector<double> diameters = stratified_diameters(grading, 3000);
    EXPECT_TRUE(std::is_sorted(diameters.begin(), diameters.end()));
    EXPECT_GE(diameters.front(), finest_diameter(grading));
    EXPECT_LE(diameters.back(), coarsest_diameter(grading));
    for (double d = 0.1e-3; d < 0.4e-3; d += 0.01e-3) {
      // One particle of 3 000 carries at most (0.4/0.186)^3/3000 = 0.3 % of the mass.
      EXPECT_NEAR(sampled_passing(diameters, d), passing_at_diameter(grading, d), 0.004) << d;
    }
    EXPECT_NEAR(mean_cube(diameters) / mean_cubed_diameter(grading), 1.0, 2e-3);
  }
}

TEST(Grading, more_particles_converge_to_the_curve) {
  const std::vector<double> diameters = stratified_diameters(three_segments(), 200000);
  EXPECT_NEAR(mean_cube(diameters) / mean_cubed_diameter(three_segments()), 1.0, 1e-5);
  EXPECT_NEAR(sampled_passing(diameters, 0.15e-3), 0.1, 1e-4);
  EXPECT_NEAR(sampled_passing(diameters, 0.25e-3), 0.7, 1e-4);
}

TEST(Grading, passing_of_the_cut_lognormal_matches_hand_values) {
  // z = ln(d/0.21)/0.2770474: cuts at -2.67810 and 2.32588 pass 0.003702 and 0.989988 of the uncut curve.
  EXPECT_EQ(passing_at_diameter(kFontainebleau, 0.1e-3), 0.0);
  EXPECT_EQ(passing_at_diameter(kFontainebleau, 0.4e-3), 1.0);
  const auto uncut = [](double d) {
    return 0.5 * std::erfc(-std::log(d / 0.21e-3) / 0.2770474 / std::sqrt(2.0));
  };
  for (const double d : {0.12e-3, 0.2e-3, 0.21e-3, 0.3e-3}) {
    const double expected = (uncut(d) - uncut(0.1e-3)) / (uncut(0.4e-3) - uncut(0.1e-3));
    EXPECT_NEAR(passing_at_diameter(kFontainebleau, d), expected, 1e-13);
  }
  // The uniformity d60/d10 of the uncut curve is exp(1.535 sigma) = 1.53; cutting narrows it by 2 %.
  const double uniformity =
      diameter_at_passing(kFontainebleau, 0.6) / diameter_at_passing(kFontainebleau, 0.1);
  EXPECT_NEAR(uniformity, 1.53, 0.03);
}

TEST(Grading, diameter_at_passing_inverts_the_curve) {
  for (const Grading& grading : {kFontainebleau, three_segments()}) {
    for (const double p : {0.001, 0.05, 0.1, 0.5, 0.69, 0.93, 0.999}) {
      EXPECT_NEAR(passing_at_diameter(grading, diameter_at_passing(grading, p)), p, 1e-13);
    }
    EXPECT_EQ(diameter_at_passing(grading, 0.0), finest_diameter(grading));
    EXPECT_EQ(diameter_at_passing(grading, 1.0), coarsest_diameter(grading));
  }
}

TEST(Grading, median_is_by_mass_and_of_the_cut_curve) {
  // The upper cut takes 1 % and the lower 0.4 %: the median moves from 0.21 mm by -0.0079 standard
  // deviations.
  EXPECT_NEAR(median_diameter(kFontainebleau), 0.20954e-3, 0.00001e-3);
  // Two thirds of the way from 0.15 to 0.25 mm in ln d.
  EXPECT_NEAR(median_diameter(three_segments()), 0.15e-3 * std::pow(0.25 / 0.15, 2.0 / 3.0), 1e-15);
}

TEST(Grading, one_particle_and_empty_segments_work) {
  EXPECT_EQ(stratified_diameters(kFontainebleau, 1).size(), 1u);
  const Grading gap = GradingPoints{{{0.1e-3, 0.0}, {0.12e-3, 0.5}, {0.3e-3, 0.5}, {0.4e-3, 1.0}}};
  for (const double d : stratified_diameters(gap, 5000)) {
    EXPECT_TRUE(d <= 0.12e-3 * (1 + 1e-12) || d >= 0.3e-3 * (1 - 1e-12)) << d;
  }
}

/// Integral of a curve over ln d between two diameters by the midpoint rule.
template <typename Curve>
double area_under(Curve curve, double from, double to) {
  constexpr int kIntervals = 200000;
  const double width = std::log(to / from) / kIntervals;
  double area = 0.0;
  for (int i = 0; i < kIntervals; ++i) area += curve(from * std::exp((i + 0.5) * width)) * width;
  return area;
}

TEST(GradingIndex, limit_areas_match_the_closed_form_values) {
  Material material;
  EXPECT_NEAR(GradingIndex(material).limit_area(), 1.29591, 0.5e-5);
  material.grading_index_max_diameter = 0.4e-3;
  EXPECT_NEAR(GradingIndex(material).limit_area(), 1.40650, 0.5e-5);
}

TEST(GradingIndex, fines_area_is_the_area_under_the_fractal_curve) {
  Material material;
  for (const double dimension : {2.6, 2.3, 2.99999, 3.0, 3.2}) {
    material.fractal_dimension = dimension;
    const GradingIndex index(material);
    for (const double end : {0.02e-3, 0.0483e-3, 0.2e-3, 0.27e-3, 0.35e-3}) {
      const auto curve = [&](double d) { return fractal_passing(d, end, 0.01e-3, 3.0 - dimension); };
      // Midpoint rule: 1e-5 at the kink at `end`, less elsewhere.
      EXPECT_NEAR(index.fines_area(end), area_under(curve, 0.01e-3, 0.27e-3), 2e-5)
          << dimension << " " << end;
    }
    EXPECT_NEAR(index.fines_area(0.005e-3), std::log(27.0), 1e-14);
  }
}

TEST(GradingIndex, particle_area_is_the_area_under_a_step_cut_at_the_limits) {
  const GradingIndex index{Material{}};
  EXPECT_NEAR(index.particle_area(0.09e-3), std::log(3.0), 1e-14);
  EXPECT_EQ(index.particle_area(0.27e-3), 0.0);
  EXPECT_EQ(index.particle_area(0.39e-3), 0.0);
  EXPECT_NEAR(index.particle_area(0.001e-3), std::log(27.0), 1e-14);
}

TEST(GradingIndex, sum_over_particles_is_the_area_under_the_passing_curve) {
  const GradingIndex index{Material{}};
  double area = 0.0, mass = 0.0;
  for (const double d : stratified_diameters(kFontainebleau, 11500)) {
    area += d * d * d * index.particle_area(d);
    mass += d * d * d;
  }
  const double curve =
      area_under([](double d) { return passing_at_diameter(kFontainebleau, d); }, 0.01e-3, 0.27e-3);
  EXPECT_NEAR(area / mass, curve, 1e-3);  // 11 500 steps for a smooth curve
  // The index of intact Fontainebleau sand is about 0.2 with these limits.
  EXPECT_NEAR(area / mass / index.limit_area(), 0.2, 0.03);
}

TEST(GradingIndex, is_1_for_the_fractal_limit_itself) {
  // Fines with the coarse end at d_max are the limit; so are particles drawn from the fractal curve.
  const GradingIndex index{Material{}};
  EXPECT_EQ(index.fines_area(0.27e-3), index.limit_area());
  double area = 0.0, passed = 0.0;
  for (int i = 1; i <= 100000; ++i) {
    const double d = 0.01e-3 * std::pow(27.0, i / 100000.0);
    const double passing = fractal_passing(d, 0.27e-3, 0.01e-3, 0.4);
    area += (passing - passed) * index.particle_area(d);
    passed = passing;
  }
  EXPECT_NEAR(area / index.limit_area(), 1.0, 1e-4);  // 1e5 steps in ln d, each ln(27)/1e5 wide
}

TEST(Breakage, hardin_index_is_the_share_of_ln_size_lost_above_silt) {
  // All mass between 0.296 and 0.592 mm becomes half as coarse: ln 2 lost of mean ln(d/0.074) = 2.5 ln 2.
  const std::vector<double> diameters = {0.148e-3, 0.296e-3, 0.592e-3};
  const std::vector<double> initial = {0.0, 0.0, 1.0};
  const std::vector<double> current = {0.0, 1.0, 1.0};
  EXPECT_NEAR(breakage_hardin(diameters, initial, current), 1.0 / 2.5, 1e-14);
  EXPECT_EQ(breakage_hardin(diameters, initial, initial), 0.0);
}

TEST(Breakage, hardin_index_does_not_count_what_is_lost_below_silt) {
  // Everything ends in one step at 0.037 mm: all the potential above 0.074 mm is used and no more.
  const std::vector<double> diameters = {0.0369e-3, 0.037e-3, 0.148e-3, 0.296e-3};
  const std::vector<double> initial = {0.0, 0.0, 0.0, 1.0};
  const std::vector<double> current = {0.0, 1.0, 1.0, 1.0};
  EXPECT_NEAR(breakage_hardin(diameters, initial, current), 1.0, 1e-14);
}

TEST(Breakage, einav_index_runs_from_0_at_the_start_to_1_at_the_ultimate_grading) {
  std::vector<double> diameters, initial, ultimate, halfway;
  for (int i = 0; i <= 50; ++i) {
    const double d = 0.01e-3 * std::pow(40.0, i / 50.0);
    diameters.push_back(d);
    initial.push_back(passing_at_diameter(kFontainebleau, d));
    ultimate.push_back(fractal_passing(d, 0.4e-3, 0.01e-3, 0.4));
    halfway.push_back(0.5 * (initial.back() + ultimate.back()));
  }
  EXPECT_EQ(breakage_einav(diameters, initial, initial, ultimate), 0.0);
  EXPECT_NEAR(breakage_einav(diameters, initial, halfway, ultimate), 0.5, 1e-13);
  EXPECT_NEAR(breakage_einav(diameters, initial, ultimate, ultimate), 1.0, 1e-13);
}

}  // namespace
}  // namespace creep
