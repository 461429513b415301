#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <random>
#include <vector>

#include "core/analysis/ensemble_mean.h"

namespace creep {
namespace {

// NIST/SEMATECH e-Handbook of Statistical Methods, 1.3.6.7.2: critical values of Student's t, three decimals.
TEST(StudentT, quantiles_are_those_of_the_tables) {
  struct Row {
    std::size_t degrees;
    double t_90, t_975, t_995;
  };
  constexpr std::array<Row, 10> kTable = {{{1, 3.078, 12.706, 63.657},
                                           {2, 1.886, 4.303, 9.925},
                                           {3, 1.638, 3.182, 5.841},
                                           {4, 1.533, 2.776, 4.604},
                                           {5, 1.476, 2.571, 4.032},
                                           {7, 1.415, 2.365, 3.499},
                                           {9, 1.383, 2.262, 3.250},
                                           {10, 1.372, 2.228, 3.169},
                                           {30, 1.310, 2.042, 2.750},
                                           {100, 1.290, 1.984, 2.626}}};
  for (const Row& row : kTable) {
    // Half of the last decimal.
    EXPECT_NEAR(student_t_quantile(0.90, row.degrees), row.t_90, 5.1e-4) << row.degrees;
    EXPECT_NEAR(student_t_quantile(0.975, row.degrees), row.t_975, 5.1e-4) << row.degrees;
    EXPECT_NEAR(student_t_quantile(0.995, row.degrees), row.t_995, 5.1e-4) << row.degrees;
  }
  // One degree of freedom is Cauchy's distribution: t = tan(pi (p - 1/2)); two: t = a sqrt(2 / (1 - a^2))
  // with a = 2 p - 1. Both exact.
  EXPECT_NEAR(student_t_quantile(0.975, 1), std::tan(0.475 * M_PI), 1e-9);
  EXPECT_NEAR(student_t_quantile(0.975, 2), 0.95 * std::sqrt(2.0 / (1.0 - 0.95 * 0.95)), 1e-10);
}

TEST(EnsembleMean, has_the_half_width_worked_by_hand) {
  // Their mean is 5, the sum of the squares about it 32, so the sample deviation is sqrt(32 / 7).
  const std::vector<double> values = {2, 4, 4, 4, 5, 5, 7, 9};
  const auto mean = ensemble_mean(values);
  ASSERT_TRUE(mean && mean->half_width);
  EXPECT_DOUBLE_EQ(mean->mean, 5.0);
  EXPECT_EQ(mean->count, 8U);
  EXPECT_NEAR(*mean->half_width, 2.365 * std::sqrt(32.0 / 7.0) / std::sqrt(8.0),
              5e-4);  // t to three decimals
}

TEST(EnsembleMean, of_one_value_has_no_uncertainty_and_of_none_is_none) {
  const auto one = ensemble_mean(std::vector<double>{3.0});
  ASSERT_TRUE(one);
  EXPECT_EQ(one->mean, 3.0);
  EXPECT_EQ(one->half_width, std::nullopt);
  EXPECT_EQ(one->low(), one->high());
  EXPECT_EQ(ensemble_mean({}), std::nullopt);
  EXPECT_EQ(ensemble_mean(std::vector<double>{2.0, 2.0})->half_width, 0.0);
}

TEST(EnsembleMean, its_interval_holds_the_true_mean_in_95_of_100_trials) {
  std::mt19937_64 random(7);
  std::normal_distribution<double> normal(10.0, 3.0);
  for (const std::size_t count : {2U, 3U, 5U}) {
    constexpr int kTrials = 20000;
    int held = 0;
    for (int trial = 0; trial < kTrials; ++trial) {
      std::vector<double> values(count);
      for (double& value : values) value = normal(random);
      const auto mean = ensemble_mean(values);
      held += mean->low() <= 10.0 && 10.0 <= mean->high() ? 1 : 0;
    }
    // Four standard deviations of the share: 4 sqrt(0.95 x 0.05 / 20000).
    EXPECT_NEAR(static_cast<double>(held) / kTrials, 0.95, 0.0062) << count;
  }
}

}  // namespace
}  // namespace creep
