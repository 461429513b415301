// Laboratory age: failure times are exact, however it is cut.
#include "core/run/ageing.h"
#include "core/experiment/fidelity.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "tests/core/dem_scenes.h"

namespace creep {
namespace {

constexpr double kForever = std::numeric_limits<double>::infinity();
constexpr double kYear = 365.25 * 86400.0;

struct Loaded {
  double diameter, crack, stress_ratio;
};

/// Grains with given cracks under given stresses.
Specimen loaded(const std::vector<Loaded>& grains) {
  Experiment experiment;
  std::vector<testing::Ball> given;
  for (std::size_t i = 0; i < grains.size(); ++i) {
    given.push_back({1e-3 * static_cast<double>(i), 0.0, 0.0, 0.5 * grains[i].diameter});
  }
  Specimen specimen = testing::balls(experiment, 1.0, given);
  for (std::size_t i = 0; i < grains.size(); ++i) {
    specimen.particles.crack[i] = grains[i].crack;
    specimen.particles.mobilised_stress[i] = grains[i].stress_ratio * specimen.particles.limit_stress[i];
  }
  return specimen;
}

double closed_form(const Loaded& grain) {
  const Material material;
  return (0.5 * grain.diameter - grain.crack) /
         (material.crack_velocity * std::pow(grain.stress_ratio, material.corrosion_index));
}

TEST(Ageing, fails_at_the_time_of_the_closed_form) {
  for (const double ratio : {0.999, 0.95, 0.83, 0.74, 0.67, 0.5}) {
    for (const double start : {0.001, 0.2, 0.49}) {
      const Loaded grain{0.21e-3, start * 0.21e-3, ratio};
      Specimen specimen = loaded({grain});
      const AgeingJump jump = age(specimen, Material{}, 1, kForever);
      EXPECT_NEAR(jump.age / closed_form(grain), 1.0, 1e-10);
      EXPECT_FALSE(jump.reached_end);
      ASSERT_EQ(jump.failures.size(), 1u);
      EXPECT_EQ(jump.failures[0].cause, FailureCause::kCrackInAgeing);
      EXPECT_NEAR(jump.failures[0].stress_ratio, ratio, 1e-14);
      EXPECT_EQ(specimen.clocks.age, jump.age);
      EXPECT_GE(specimen.particles.crack[0], specimen.particles.body[0].radius);
    }
  }
}

TEST(Ageing, has_the_failure_times_of_the_crack_clock) {
  // Stress ratios worked out elsewhere to four digits for a0 = 0.001 d: half a digit is 60 x 0.5e-4/0.67 =
  // 0.5 %.
  struct Known {
    double diameter, ratio, time;
  };
  for (const Known& known : {Known{0.21e-3, 1.0, 1.0477e-3},
                             {0.21e-3, 0.9631, 1e-2},
                             {0.21e-3, 0.9268, 0.1},
                             {0.21e-3, 0.8331, 60.0},
                             {0.21e-3, 0.8017, 600.0},
                             {0.21e-3, 0.7650, 1e4},
                             {0.21e-3, 0.7380, 86400.0},
                             {0.21e-3, 0.7295, 2 * 86400.0},
                             {0.21e-3, 0.6689, kYear},
                             {0.12e-3, 0.7312, 86400.0},
                             {0.40e-3, 0.7460, 86400.0}}) {
    Specimen specimen = loaded({{known.diameter, 0.001 * known.diameter, known.ratio}});
    EXPECT_NEAR(age(specimen, Material{}, 1, kForever).age / known.time, 1.0, 6e-3) << known.ratio;
  }
}

const std::vector<Loaded> kFive = {{0.21e-3, 0.01e-3, 0.74},
                                   {0.21e-3, 0.01e-3, 0.80},
                                   {0.30e-3, 0.01e-3, 0.77},
                                   {0.21e-3, 0.09e-3, 0.74},
                                   {0.21e-3, 0.01e-3, 0.60}};

TEST(Ageing, stops_at_the_failure_that_was_wanted_and_breaks_all_before_it) {
  std::vector<double> times;
  for (const Loaded& grain : kFive) times.push_back(closed_form(grain));
  std::vector<double> ordered = times;
  std::sort(ordered.begin(), ordered.end());
  for (std::size_t wanted = 1; wanted <= kFive.size(); ++wanted) {
    Specimen specimen = loaded(kFive);
    const AgeingJump jump = age(specimen, Material{}, static_cast<std::int64_t>(wanted), kForever);
    EXPECT_NEAR(jump.age / ordered[wanted - 1], 1.0, 1e-10);
    ASSERT_EQ(jump.failures.size(), wanted);
    for (std::size_t k = 0; k < wanted; ++k) {
      if (k > 0) {
        EXPECT_LT(jump.failures[k - 1].index, jump.failures[k].index);
      }
      EXPECT_LE(times[static_cast<std::size_t>(jump.failures[k].index)], jump.age * (1.0 + 1e-10));
    }
  }
}

TEST(Ageing, does_not_depend_on_how_time_is_cut) {
  Specimen whole = loaded(kFive);
  const AgeingJump at_once = age(whole, Material{}, 1, kForever);
  for (const int cuts : {2, 7, 100}) {
    Specimen cut = loaded(kFive);
    for (int k = 0; k + 1 < cuts; ++k) {
      const AgeingJump part = age(cut, Material{}, 1, at_once.age / cuts);
      EXPECT_TRUE(part.reached_end);
      EXPECT_TRUE(part.failures.empty());
    }
    const AgeingJump last = age(cut, Material{}, 1, kForever);
    ASSERT_EQ(last.failures.size(), 1u);
    EXPECT_EQ(last.failures[0].index, at_once.failures[0].index);
    EXPECT_NEAR(cut.clocks.age / at_once.age, 1.0, 1e-12);  // roundings of a hundred additions
    for (std::size_t i = 0; i < kFive.size(); ++i) {
      EXPECT_NEAR(cut.particles.crack[i] / whole.particles.crack[i], 1.0, 1e-12);
    }
  }
}

TEST(Ageing, ends_with_the_time_left_if_too_few_fail) {
  const double first = closed_form(kFive[1]);
  Specimen none = loaded(kFive);
  const AgeingJump short_jump = age(none, Material{}, 3, 0.5 * first);
  EXPECT_TRUE(short_jump.reached_end);
  EXPECT_EQ(short_jump.age, 0.5 * first);
  EXPECT_TRUE(short_jump.failures.empty());
  EXPECT_EQ(none.clocks.age, 0.5 * first);
  const double radius = 0.5 * kFive[1].diameter;
  EXPECT_NEAR(none.particles.crack[1], 0.5 * (radius + kFive[1].crack), 1e-10 * radius);

  Specimen one = loaded(kFive);
  const AgeingJump longer = age(one, Material{}, 3, 1.01 * first);
  EXPECT_TRUE(longer.reached_end);
  ASSERT_EQ(longer.failures.size(), 1u);
  EXPECT_EQ(longer.failures[0].index, 1);

  Specimen more = loaded(kFive);
  EXPECT_TRUE(age(more, Material{}, 6, 1e30).reached_end) << "more wanted than there are";
}

TEST(Ageing, breaks_all_that_fail_at_the_same_instant) {
  std::vector<Loaded> twins(4, kFive[0]);
  twins.push_back(kFive[4]);
  Specimen specimen = loaded(twins);
  const AgeingJump jump = age(specimen, Material{}, 2, kForever);
  EXPECT_EQ(jump.failures.size(), 4u);
  EXPECT_FALSE(jump.reached_end);
}

TEST(Ageing, never_breaks_the_unloaded_or_the_finest) {
  std::vector<Loaded> grains = {{0.21e-3, 0.1e-3, 0.0}, {0.11e-3, 0.05e-3, 0.99}};
  Specimen specimen = loaded(grains);
  const AgeingJump jump = age(specimen, Material{}, 1, 1e12);
  EXPECT_TRUE(jump.reached_end);
  EXPECT_TRUE(jump.failures.empty());
  EXPECT_EQ(specimen.particles.crack[0], 0.1e-3);
}

TEST(Ageing, wants_26_failures_in_ten_thousand_grains) {
  const Numerics numerics;
  EXPECT_EQ(breakages_per_ageing(numerics, 11500), 30);
  EXPECT_EQ(breakages_per_ageing(numerics, 3000), 8);
  EXPECT_EQ(breakages_per_ageing(numerics, 100), 1);
  Numerics asked;
  asked.breakages_per_ageing = 5;
  EXPECT_EQ(breakages_per_ageing(asked, 11500), 5);
}

TEST(Ageing, a_fraction_asked_for_grows_with_the_specimen) {
  Numerics numerics;
  numerics.breakage_fraction = 0.00033;
  EXPECT_EQ(breakages_per_ageing(numerics, 800), 1);
  EXPECT_EQ(breakages_per_ageing(numerics, 3000), 1);
  EXPECT_EQ(breakages_per_ageing(numerics, 11500), 4);
  EXPECT_EQ(breakages_per_ageing(numerics, 30000), 10);
}

TEST(Ageing, time_to_failures_is_the_age_at_which_so_many_have_failed) {
  for (std::int64_t wanted = 1; wanted <= static_cast<std::int64_t>(kFive.size()); ++wanted) {
    Specimen specimen = loaded(kFive);
    const double time = time_to_failures(specimen, Material{}, wanted);
    EXPECT_EQ(time, age(specimen, Material{}, wanted, kForever).age);
  }
  EXPECT_EQ(time_to_failures(loaded(kFive), Material{}, 6), kForever);
}

TEST(AgeingError, is_half_the_misjudged_step_over_the_step_in_ln_time) {
  // From 10 s to 10 e s, another 10 e s promised and e^0.2 times the end found:
  // d = 0.2, step 1, E = 0.2 / 2 / 1. Tolerances: rounding.
  const double after = 10.0 * std::exp(1.0);
  const double found = 2.0 * after * std::exp(0.2) - after;
  EXPECT_NEAR(relative_strain_error({10.0, after, after, found, 1e9}), 0.1, 1e-12);
  EXPECT_NEAR(relative_strain_error({10.0, after, found, after, 1e9}), 0.1, 1e-12) << "sooner or later alike";
  EXPECT_EQ(relative_strain_error({10.0, after, after, after, 1e9}), 0.0);
  EXPECT_EQ(relative_strain_error({10.0, after, 50.0, kForever, 40.0}), 0.0) << "both beyond the end";
}

TEST(AgeingError, sets_n_age_in_inverse_proportion_within_a_factor_of_2) {
  EXPECT_EQ(adapted_breakages(10, 0.10, 0.12, 11500), 12);
  EXPECT_EQ(adapted_breakages(10, 0.15, 0.12, 11500), 8);
  EXPECT_EQ(adapted_breakages(10, 9.0, 0.12, 11500), 5);
  EXPECT_EQ(adapted_breakages(10, 0.0, 0.12, 11500), 20);
  EXPECT_EQ(adapted_breakages(1, 9.0, 0.12, 11500), 1);
  EXPECT_EQ(adapted_breakages(290, 0.0, 0.12, 11500), 299) << "0.026 of the count";
  EXPECT_EQ(adapted_breakages(1, 0.0, 0.12, 20), 1);
}

}  // namespace
}  // namespace creep
