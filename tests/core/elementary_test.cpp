#include "core/arithmetic/elementary.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>

#include "core/arithmetic/digest.h"

namespace creep {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

struct Value {
  double x;
  double expected;
};

// Expected values: multiple-precision arithmetic at 200 bits, of the double nearest to the argument.

TEST(Elementary, exp_is_right_to_the_last_bits) {
  const std::array<Value, 5> values = {{{1e-9, 1.0000000010000000005},
                                        {0.5, 1.6487212707001281468},
                                        {-3.25, 0.038774207831722009887},
                                        {17.75, 51136035.38059727805},
                                        {709.5, 1.3549863193146328309e308}}};
  for (const auto& [x, expected] : values) {
    EXPECT_NEAR(elementary::exp(x) / expected, 1.0, 1e-15) << x;  // the documented error
  }
}

TEST(Elementary, exp_saturates_at_the_ends_of_the_range) {
  EXPECT_EQ(elementary::exp(0.0), 1.0);
  EXPECT_EQ(elementary::exp(710.0), kInfinity);
  EXPECT_EQ(elementary::exp(kInfinity), kInfinity);
  EXPECT_EQ(elementary::exp(-746.0), 0.0);
  EXPECT_EQ(elementary::exp(-kInfinity), 0.0);
  EXPECT_GT(elementary::exp(-744.0), 0.0);  // subnormal, not flushed
  EXPECT_TRUE(std::isnan(elementary::exp(std::nan(""))));
}

TEST(Elementary, log_is_right_to_the_last_bits_also_next_to_1) {
  const std::array<Value, 9> values = {{{5e-324, -744.44007192138126231},
                                        {1e-300, -690.77552789821370518},
                                        {0.0625, -2.7725887222397812377},
                                        {0.7071, -0.34658318037194200028},
                                        {0.9999999, -1.0000000494736474329e-7},
                                        {1.0000001, 9.9999995058387045178e-8},
                                        {1.4143, 0.34663470904431701146},
                                        {2.75, 1.0116009116784799252},
                                        {1e300, 690.77552789821370526}}};
  for (const auto& [x, expected] : values) {
    EXPECT_NEAR(elementary::log(x) / expected, 1.0, 1e-15) << x;  // the documented error
  }
  EXPECT_EQ(elementary::log(1.0), 0.0);
  EXPECT_EQ(elementary::log(0.0), -kInfinity);
  EXPECT_EQ(elementary::log(kInfinity), kInfinity);
  EXPECT_TRUE(std::isnan(elementary::log(-1.0)));
}

TEST(Elementary, pow_stays_accurate_for_large_exponents) {
  struct Case {
    double x, y, expected;
  };
  const std::array<Case, 8> cases = {{{0.738, 60.0, 1.2116626181741484927e-8},
                                      {0.9999, 1e6, 3.7015207857933868323e-44},
                                      {1.7, 0.8347165, 1.5572542222954056549},
                                      {0.105, -0.25, 1.756720523942792177},
                                      {1e-3, 1.8759038, 2.3566147956167090869e-6},
                                      {30.0, 58.0, 4.7101286972462448349e85},
                                      {0.03, 57.0, 1.5700428990820782998e-87},
                                      {1e-5, 17.3, 3.1622776601683579385e-87}}};
  for (const auto& [x, y, expected] : cases) {
    // |y log x| is up to 200 here; a logarithm rounded to double would give errors of 4e-14.
    EXPECT_NEAR(elementary::pow(x, y) / expected, 1.0, 2e-15) << x << "^" << y;
  }
}

TEST(Elementary, pow_at_its_edges) {
  EXPECT_EQ(elementary::pow(0.0, 1.5), 0.0);
  EXPECT_EQ(elementary::pow(0.0, 0.0), 1.0);
  EXPECT_EQ(elementary::pow(0.0, -1.0), kInfinity);
  EXPECT_EQ(elementary::pow(7.0, 0.0), 1.0);
  EXPECT_EQ(elementary::pow(1.0, 1e300), 1.0);
  EXPECT_EQ(elementary::pow(2.0, 1e6), kInfinity);
  EXPECT_EQ(elementary::pow(2.0, -1e6), 0.0);
  EXPECT_TRUE(std::isnan(elementary::pow(-2.0, 2.0)));
}

TEST(Elementary, normal_cdf_is_right_in_the_middle_and_in_the_tail) {
  const std::array<Value, 11> values = {{{-38.0, 2.8854283600687843084e-316},
                                         {-10.0, 7.619853024160526066e-24},
                                         {-5.0, 2.8665157187919391167e-7},
                                         {-4.0, 0.000031671241833119921254},
                                         {-3.999, 0.000031805340054202033348},
                                         {-2.678, 0.0037031609167462843811},
                                         {-0.5, 0.30853753872598689636},
                                         {0.0, 0.5},
                                         {0.3, 0.61791142218895263307},
                                         {2.326, 0.98999072465913233454},
                                         {6.0, 0.99999999901341235496}}};
  for (const auto& [z, expected] : values) {
    const double value = elementary::normal_cdf(z);
    EXPECT_NEAR(value, expected, 1e-15) << z;
    if (z > -37.0 && z <= -4.0) {
      EXPECT_NEAR(value / expected, 1.0, 1e-13) << z;
    }
  }
}

TEST(Elementary, inverse_normal_cdf_is_right_in_all_three_regions_of_the_algorithm) {
  const std::array<Value, 10> values = {{{1e-300, -37.047096299361199237},
                                         {1e-20, -9.2623400897984075796},
                                         {1e-6, -4.7534243088228989573},
                                         {0.02, -2.0537489106318230443},
                                         {0.074, -1.4466320671589785099},
                                         {0.0751, -1.4388253927525399824},
                                         {0.25, -0.6744897501960817432},
                                         {0.75, 0.6744897501960817432},
                                         {0.975, 1.9599639845400538556},
                                         {0.999, 3.0902323061678132778}}};
  for (const auto& [p, expected] : values) {
    EXPECT_NEAR(elementary::inverse_normal_cdf(p) / expected, 1.0, 2e-15)
        << p;  // PPND16 promises about 1e-16
  }
  EXPECT_EQ(elementary::inverse_normal_cdf(0.5), 0.0);
  EXPECT_EQ(elementary::inverse_normal_cdf(0.0), -kInfinity);
  EXPECT_EQ(elementary::inverse_normal_cdf(1.0), kInfinity);
  EXPECT_TRUE(std::isnan(elementary::inverse_normal_cdf(1.5)));
}

TEST(Elementary, sine_and_cosine_of_a_turn) {
  struct Case {
    double turn, sine, cosine;
  };
  const std::array<Case, 4> cases = {{{0.1, 0.58778525229247315739, 0.8090169943749474036},
                                      {0.37, 0.72896862742141154225, -0.68454710592868865339},
                                      {-0.61, 0.63742398974868964568, -0.77051324277578928416},
                                      {2.9, -0.58778525229247358065, 0.80901699437494709608}}};
  for (const auto& [turn, sine, cosine] : cases) {
    EXPECT_NEAR(elementary::sin_cos_turn(turn).sin, sine, 1e-15) << turn;
    EXPECT_NEAR(elementary::sin_cos_turn(turn).cos, cosine, 1e-15) << turn;
  }
  EXPECT_EQ(elementary::sin_cos_turn(0.25).sin, 1.0);
  EXPECT_EQ(elementary::sin_cos_turn(0.25).cos, 0.0);
  EXPECT_EQ(elementary::sin_cos_turn(-0.5).cos, -1.0);
  EXPECT_EQ(elementary::sin_cos_turn(0.75).sin, -1.0);
}

TEST(Elementary, bits_are_the_same_in_every_build) {
  Digest digest;
  for (int i = 1; i <= 2000; ++i) {
    const double x = i / 2001.0;
    digest.add(elementary::exp(300.0 * (x - 0.5)));
    digest.add(elementary::log(x * x * x));
    digest.add(elementary::pow(x, 60.0 * x));
    digest.add(elementary::normal_cdf(20.0 * (x - 0.7)));
    digest.add(elementary::inverse_normal_cdf(x));
    digest.add(elementary::sin_cos_turn(x).sin);
    digest.add(elementary::sin_cos_turn(x).cos);
  }
  // Of a Release build; Debug, sanitized and other-ISA builds must reproduce it.
  EXPECT_EQ(digest.hex(), "4b4d5236dffe38259e6e2f85275437ae57b9da6a549df1f18950ec0d0e21bf38");
}

}  // namespace
}  // namespace creep
