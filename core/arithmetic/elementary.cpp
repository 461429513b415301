#include "core/arithmetic/elementary.h"

#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>

namespace creep::elementary {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kTwoPi = 6.283185307179586;
constexpr double kInverseLn2 = 1.4426950408889634;
// ln 2 in two parts; the first has 21 trailing zero bits, so that its product with an exponent is exact.
constexpr double kLn2High = 6.93147180369123816490e-01;
constexpr double kLn2Low = 1.90821492927058770002e-10;
// Adding and subtracting 1.5 x 2^52 rounds to the nearest integer, ties to even, for |x| < 2^51.
constexpr double kRounder = 6755399441055744.0;

constexpr int kExponentBias = 1023;
constexpr int kMantissaBits = 52;
constexpr std::uint64_t kMantissaMask = (std::uint64_t{1} << kMantissaBits) - 1;

/// An unevaluated sum high + low with |low| <= half an ulp of high.
struct DoubleDouble {
  double high = 0.0;
  double low = 0.0;
};

/// Exact sum of any two doubles (Knuth).
DoubleDouble two_sum(double a, double b) {
  const double sum = a + b;
  const double b_part = sum - a;
  return {sum, (a - (sum - b_part)) + (b - b_part)};
}

/// Exact sum for |a| >= |b| (Dekker).
DoubleDouble fast_two_sum(double a, double b) {
  const double sum = a + b;
  return {sum, b - (sum - a)};
}

double round_to_integer(double x) { return (x + kRounder) - kRounder; }

/// 2^k for -1022 <= k <= 1023.
double power_of_two(int k) {
  return std::bit_cast<double>(static_cast<std::uint64_t>(kExponentBias + k) << kMantissaBits);
}

/// 1/n!; n! is exact in double up to 18.
constexpr std::array<double, 19> make_inverse_factorials() {
  std::array<double, 19> inverse{};
  double factorial = 1.0;
  for (std::size_t n = 0; n < inverse.size(); ++n) {
    if (n > 0) factorial *= static_cast<double>(n);
    inverse[n] = 1.0 / factorial;
  }
  return inverse;
}
constexpr std::array<double, 19> kInverseFactorial = make_inverse_factorials();

/// e^(high + low): x = k ln2 + r with |r| <= ln2/2; Taylor series to r^14, whose remainder is below 1e-19.
double exp_of_sum(double high, double low) {
  if (high != high) return high;
  if (high > 709.79) return kInfinity;
  if (high < -745.2) return 0.0;
  const double k = round_to_integer(high * kInverseLn2);
  const double r = std::fma(-k, kLn2Low, std::fma(-k, kLn2High, high)) + low;
  double tail = kInverseFactorial[14];
  for (std::size_t n = 13; n >= 2; --n) tail = std::fma(tail, r, kInverseFactorial[n]);
  const double value = 1.0 + std::fma(tail, r * r, r);
  const int exponent = static_cast<int>(k);
  const int half = exponent / 2;
  return (value * power_of_two(half)) * power_of_two(exponent - half);
}

/// log x to about 100 bits for finite x > 0: x = 2^e m with m in [sqrt(1/2), sqrt 2), and
/// log m = 2 atanh(s), s = (m - 1)/(m + 1), |s| <= 0.1716. Only the leading term needs the extra bits.
DoubleDouble log_in_two_parts(double x) {
  int exponent = 0;
  if (x < std::numeric_limits<double>::min()) {
    x *= power_of_two(54);
    exponent = -54;
  }
  const std::uint64_t bits = std::bit_cast<std::uint64_t>(x);
  exponent += static_cast<int>(bits >> kMantissaBits) - kExponentBias;
  double m = std::bit_cast<double>((bits & kMantissaMask) | (std::uint64_t{kExponentBias} << kMantissaBits));
  if (m >= 1.4142135623730951) {
    m *= 0.5;
    ++exponent;
  }
  const double numerator = m - 1.0;  // exact
  const DoubleDouble denominator = two_sum(m, 1.0);
  const double s = numerator / denominator.high;
  const double s_low =
      std::fma(-s, denominator.low, std::fma(-s, denominator.high, numerator)) / denominator.high;
  const double s2 = s * s;
  double series = 1.0 / 27.0;
  for (int n = 25; n >= 3; n -= 2) series = std::fma(series, s2, 1.0 / n);
  const double tail = 2.0 * std::fma(s2 * s, series, s_low);
  const double e = exponent;
  const DoubleDouble lead = two_sum(e * kLn2High, 2.0 * s);
  return fast_two_sum(lead.high, lead.low + std::fma(e, kLn2Low, tail));
}

}  // namespace

double exp(double x) { return exp_of_sum(x, 0.0); }

double log(double x) {
  if (x == 0.0) return -kInfinity;
  if (!(x > 0.0)) return kNan;
  if (x == kInfinity) return x;
  return log_in_two_parts(x).high;
}

double pow(double x, double y) {
  if (y == 0.0) return 1.0;
  if (x == 0.0) return y > 0.0 ? 0.0 : kInfinity;
  if (!(x > 0.0)) return kNan;
  if (x == kInfinity) return y > 0.0 ? kInfinity : 0.0;
  const DoubleDouble logarithm = log_in_two_parts(x);
  const double product = y * logarithm.high;
  if (!(std::fabs(product) < 800.0)) return product > 0.0 ? kInfinity : (product < 0.0 ? 0.0 : kNan);
  const double product_low = std::fma(y, logarithm.low, std::fma(y, logarithm.high, -product));
  return exp_of_sum(product, product_low);
}

double normal_cdf(double z) {
  if (z != z) return z;
  if (z > 9.0) return 1.0;  // 1 - 1e-19
  if (z < -40.0) return 0.0;
  const double density = exp(-0.5 * z * z) / std::sqrt(kTwoPi);
  if (z > -4.0) {
    // Phi = 1/2 + phi (z + z^3/3 + z^5/(3 5) + ...) (Marsaglia 2004): all terms have one sign.
    double sum = z;
    double term = z;
    for (int n = 3; n < 400 && sum + term != sum - term; n += 2) {
      term *= z * z / n;
      sum += term;
    }
    return std::fma(density, sum, 0.5);
  }
  // Tail, Laplace's continued fraction: Phi(-x) = phi/(x + 1/(x + 2/(x + 3/(x + ...)))).
  const double x = -z;
  double fraction = x;
  for (int n = 150; n >= 1; --n) fraction = x + n / fraction;
  return density / fraction;
}

double inverse_normal_cdf(double p) {
  if (!(p >= 0.0 && p <= 1.0)) return kNan;
  if (p == 0.0) return -kInfinity;
  if (p == 1.0) return kInfinity;
  using Coefficients = std::array<double, 8>;  // highest power first
  const auto ratio = [](const Coefficients& above, const Coefficients& below, double r) {
    double a = above[0];
    double b = below[0];
    for (std::size_t n = 1; n < above.size(); ++n) {
      a = std::fma(a, r, above[n]);
      b = std::fma(b, r, below[n]);
    }
    return a / b;
  };
  const double q = p - 0.5;
  if (std::fabs(q) <= 0.425) {
    constexpr Coefficients kAbove = {2.5090809287301226727e+3, 3.3430575583588128105e+4,
                                     6.7265770927008700853e+4, 4.5921953931549871457e+4,
                                     1.3731693765509461125e+4, 1.9715909503065514427e+3,
                                     1.3314166789178437745e+2, 3.3871328727963666080e+0};
    constexpr Coefficients kBelow = {5.2264952788528545610e+3, 2.8729085735721942674e+4,
                                     3.9307895800092710610e+4, 2.1213794301586595867e+4,
                                     5.3941960214247511077e+3, 6.8718700749205790830e+2,
                                     4.2313330701600911252e+1, 1.0};
    return q * ratio(kAbove, kBelow, 0.180625 - q * q);
  }
  const double r = std::sqrt(-log(q < 0.0 ? p : 1.0 - p));
  double quantile = 0.0;
  if (r <= 5.0) {
    constexpr Coefficients kAbove = {7.74545014278341407640e-4, 2.27238449892691845833e-2,
                                     2.41780725177450611770e-1, 1.27045825245236838258e+0,
                                     3.64784832476320460504e+0, 5.76949722146069140550e+0,
                                     4.63033784615654529590e+0, 1.42343711074968357734e+0};
    constexpr Coefficients kBelow = {1.05075007164441684324e-9, 5.47593808499534494600e-4,
                                     1.51986665636164571966e-2, 1.48103976427480074590e-1,
                                     6.89767334985100004550e-1, 1.67638483018380384940e+0,
                                     2.05319162663775882187e+0, 1.0};
    quantile = ratio(kAbove, kBelow, r - 1.6);
  } else {
    constexpr Coefficients kAbove = {2.01033439929228813265e-7, 2.71155556874348757815e-5,
                                     1.24266094738807843860e-3, 2.65321895265761230930e-2,
                                     2.96560571828504891230e-1, 1.78482653991729133580e+0,
                                     5.46378491116411436990e+0, 6.65790464350110377720e+0};
    constexpr Coefficients kBelow = {2.04426310338993978564e-15, 1.42151175831644588870e-7,
                                     1.84631831751005468180e-5,  7.86869131145613259100e-4,
                                     1.48753612908506148525e-2,  1.36929880922735805310e-1,
                                     5.99832206555887937690e-1,  1.0};
    quantile = ratio(kAbove, kBelow, r - 5.0);
  }
  return q < 0.0 ? -quantile : quantile;
}

SinCos sin_cos_turn(double turn) {
  // Nearest quarter turn q and the exact rest, at most an eighth of a turn: |angle| <= pi/4. The Taylor
  // remainders are below 1e-18.
  const double quarters = round_to_integer(4.0 * turn);
  const double angle = kTwoPi * (turn - 0.25 * quarters);
  const double a2 = angle * angle;
  double sine = kInverseFactorial[17];
  for (std::size_t n = 15; n >= 3; n -= 2) sine = std::fma(sine, -a2, kInverseFactorial[n]);
  sine = std::fma(-a2 * angle, sine, angle);
  double cosine = kInverseFactorial[18];
  for (std::size_t n = 16; n >= 2; n -= 2) cosine = std::fma(cosine, -a2, kInverseFactorial[n]);
  cosine = std::fma(-a2, cosine, 1.0);
  switch (static_cast<std::int64_t>(quarters) & 3) {
    case 0:
      return {sine, cosine};
    case 1:
      return {cosine, -sine};
    case 2:
      return {-sine, -cosine};
    default:
      return {-cosine, sine};
  }
}

}  // namespace creep::elementary
