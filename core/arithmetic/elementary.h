// exp, log, pow and their kin for everything that can reach the state.
//
// libm gives other bits on other machines and versions; these use only +, -, *, /, std::fma and std::sqrt,
// which IEEE 754 rounds correctly everywhere, so their results are the same bits on every build and
// processor.
#pragma once

namespace creep::elementary {

/// e^x; relative error <= 1e-15 while the result is normal; 0 below and +inf above the range of double.
double exp(double x);

/// Natural logarithm; relative error <= 1e-15. -inf at 0, NaN below.
double log(double x);

/// x^y for x >= 0; relative error <= 1e-15 (1 + |y log x| / 200) while the result is normal. 0^y is 0, 1 or
/// +inf for y above, at or below 0; NaN for x < 0.
double pow(double x, double y);

/// Probability that a standard normal variable is below z [-]; absolute error <= 1e-15, and below -4
/// relative error <= 1e-13 until it underflows.
double normal_cdf(double z);

/// Standard normal quantile of p in (0, 1); relative error about 1e-15 (Wichura 1988, algorithm AS 241,
/// PPND16). -inf at 0, +inf at 1, NaN outside.
double inverse_normal_cdf(double p);

struct SinCos {
  double sin = 0.0;
  double cos = 1.0;
};

/// Sine and cosine of 2 pi `turn`; absolute error <= 1e-15. Exact at multiples of a quarter turn. |turn| <
/// 2^50.
SinCos sin_cos_turn(double turn);

}  // namespace creep::elementary
