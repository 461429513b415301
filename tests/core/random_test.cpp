#include "core/arithmetic/random.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>

namespace creep {
namespace {

/// What uniform() makes of the first two words of a Philox block.
double from_words(std::uint64_t first, std::uint64_t second) {
  return (static_cast<double>(((second << 32) | first) >> 12) + 0.5) * 0x1p-52;
}

TEST(Random, matches_the_known_answers_of_philox_4x32_10) {
  // Random123's kat_vectors: counter and key all 0, then digits of pi.
  EXPECT_EQ(uniform(0, 0, static_cast<RandomEvent>(0), 0), from_words(0x6627e8d5, 0xe169c58d));
  EXPECT_EQ(uniform(0x299f31d0a4093822, 0x85a308d3243f6a88, static_cast<RandomEvent>(0x13198a2e), 0x03707344),
            from_words(0xd16cfe09, 0x94fdcceb));
}

TEST(Random, every_part_of_the_key_gives_another_number) {
  const std::set<double> values = {uniform(1, 1, RandomEvent::kStrength),
                                   uniform(2, 1, RandomEvent::kStrength),
                                   uniform(1, 2, RandomEvent::kStrength),
                                   uniform(1, 1, RandomEvent::kCrack),
                                   uniform(1, 1, RandomEvent::kStrength, 1),
                                   uniform(1 + (std::uint64_t{1} << 32), 1, RandomEvent::kStrength),
                                   uniform(1, 1 + (std::uint64_t{1} << 32), RandomEvent::kStrength)};
  EXPECT_EQ(values.size(), 7u);
}

TEST(Random, uniform_is_open_and_has_the_moments_of_a_uniform_variable) {
  constexpr int kCount = 100000;
  double sum = 0.0, squares = 0.0;
  for (std::uint64_t id = 0; id < kCount; ++id) {
    const double u = uniform(7, id, RandomEvent::kPosition);
    ASSERT_GT(u, 0.0);
    ASSERT_LT(u, 1.0);
    sum += u;
    squares += u * u;
  }
  // Four standard errors: sqrt(1/12/n) and sqrt(4/45/n).
  EXPECT_NEAR(sum / kCount, 0.5, 4.0 * std::sqrt(1.0 / 12.0 / kCount));
  EXPECT_NEAR(squares / kCount, 1.0 / 3.0, 4.0 * std::sqrt(4.0 / 45.0 / kCount));
}

TEST(Random, the_largest_and_the_smallest_uniform_are_not_1_and_0) {
  EXPECT_LT(from_words(0xffffffff, 0xffffffff), 1.0);
  EXPECT_GT(from_words(0, 0), 0.0);
  EXPECT_EQ(from_words(0, 0), 1.0 - from_words(0xffffffff, 0xffffffff));
}

TEST(Random, normal_has_the_moments_of_a_standard_normal_variable) {
  constexpr int kCount = 100000;
  double sum = 0.0, squares = 0.0, fourth = 0.0;
  for (std::uint64_t id = 0; id < kCount; ++id) {
    const double x = normal(7, id, RandomEvent::kStrength);
    sum += x;
    squares += x * x;
    fourth += x * x * x * x;
  }
  // Four standard errors: variances of x, x^2, x^4 are 1, 2, 96.
  EXPECT_NEAR(sum / kCount, 0.0, 4.0 * std::sqrt(1.0 / kCount));
  EXPECT_NEAR(squares / kCount, 1.0, 4.0 * std::sqrt(2.0 / kCount));
  EXPECT_NEAR(fourth / kCount, 3.0, 4.0 * std::sqrt(96.0 / kCount));
}

}  // namespace
}  // namespace creep
