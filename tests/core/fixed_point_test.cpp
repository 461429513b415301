#include "core/arithmetic/fixed_point.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "core/arithmetic/random.h"

namespace creep {
namespace {

std::vector<double> numbers(std::uint64_t count) {
  std::vector<double> values;
  for (std::uint64_t i = 0; i < count; ++i) {
    values.push_back(std::ldexp(normal(3, i, RandomEvent::kShuffle), static_cast<int>(i % 40) - 30));
  }
  return values;
}

TEST(FixedSum, does_not_depend_on_the_order_or_the_grouping) {
  const std::vector<double> values = numbers(10000);
  FixedSum forward(-70), backward(-70), odd(-70), even(-70);
  double plain_forward = 0.0, plain_backward = 0.0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    forward.add(values[i]);
    backward.add(values[values.size() - 1 - i]);
    (i % 2 == 0 ? even : odd).add(values[i]);
    plain_forward += values[i];
    plain_backward += values[values.size() - 1 - i];
  }
  odd.merge(even);
  ASSERT_NE(plain_forward, plain_backward) << "the numbers are too easy for this test";
  EXPECT_EQ(forward.value(), backward.value());
  EXPECT_EQ(forward.value(), odd.value());
  EXPECT_EQ(forward.high(), odd.high());
  EXPECT_EQ(forward.low(), odd.low());
  EXPECT_FALSE(forward.saturated());
  EXPECT_NEAR(forward.value(), plain_forward, 1e-8);  // 1e4 roundings of a double sum of up to 1e4
}

TEST(FixedSum, rounds_each_addend_to_the_nearest_quantum_ties_to_even) {
  const auto rounded = [](double x) {
    FixedSum sum(0);
    sum.add(x);
    return sum.value();
  };
  EXPECT_EQ(rounded(0.49), 0.0);
  EXPECT_EQ(rounded(0.5), 0.0);
  EXPECT_EQ(rounded(1.5), 2.0);
  EXPECT_EQ(rounded(-1.5), -2.0);
  EXPECT_EQ(rounded(-2.6), -3.0);
  EXPECT_EQ(rounded(0x1p52 + 1.0), 0x1p52 + 1.0);
  EXPECT_EQ(rounded(0x1p51 + 0.5), 0x1p51);
  EXPECT_EQ(rounded(-0x1p62), -0x1p62);
  EXPECT_EQ(rounded(-0x1.8p63), -0x1.8p63);
  EXPECT_EQ(rounded(0x1.fp95), 0x1.fp95);
}

TEST(FixedSum, keeps_small_addends_beside_large_ones) {
  FixedSum sum(-40);
  sum.add(1e6);
  for (int i = 0; i < 1000; ++i) sum.add(0x1p-40);
  sum.add(-1e6);
  EXPECT_EQ(sum.value(), 1000.0 * 0x1p-40);
}

TEST(FixedSum, says_when_an_addend_does_not_fit) {
  for (const double bad : {0x1p96, -0x1p96, std::numeric_limits<double>::infinity(), std::nan("")}) {
    FixedSum sum(0);
    sum.add(1.0);
    sum.add(bad);
    EXPECT_TRUE(sum.saturated()) << bad;
    FixedSum other(0);
    other.merge(sum);
    EXPECT_TRUE(other.saturated()) << bad;
  }
}

TEST(FixedSum, survives_a_checkpoint) {
  for (const double total : {-3.0, 0.0, 5.0, 0x1p40, -0x1p40}) {
    FixedSum sum(-60);
    for (int i = 0; i < 4; ++i)
      sum.add(total > 4.0 || total < -4.0 ? std::copysign(4.5, total) : total / 4.0);
    const FixedSum copy = FixedSum::from_halves(-60, sum.high(), sum.low(), sum.saturated());
    EXPECT_EQ(copy.value(), sum.value());
    EXPECT_EQ(copy.high(), sum.high());
    EXPECT_EQ(copy.low(), sum.low());
  }
  // More than 64 bits: 100 addends of 2^62 quanta.
  FixedSum large(0);
  for (int i = 0; i < 100; ++i) large.add(-0x1p62);
  EXPECT_EQ(large.value(), -100.0 * 0x1p62);
  EXPECT_EQ(FixedSum::from_halves(0, large.high(), large.low()).value(), large.value());
}

}  // namespace
}  // namespace creep
