#include "client/results/broken_fraction.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace creepctl {
namespace {

constexpr int kClasses = 4;

struct Curve {
  double creep_time = 0.0;
  std::vector<double> diameter;
  std::vector<double> passing;
};

std::vector<Curve> grading_curves(const NumberTable& grading) {
  std::vector<Curve> curves;
  double number = std::numeric_limits<double>::quiet_NaN();
  for (std::size_t row = 0; row < grading.rows(); ++row) {
    if (grading.at(row, "curve") != number) {
      number = grading.at(row, "curve");
      curves.push_back({grading.at(row, "creep_time_s"), {}, {}});
    }
    curves.back().diameter.push_back(grading.at(row, "diameter_m"));
    curves.back().passing.push_back(grading.at(row, "passing"));
  }
  return curves;
}

/// Particles between two sizes for a specimen of unit mass and grains of unit density times pi/6.
double number_between(const Curve& curve, double smallest, double largest) {
  double number = 0.0;
  for (std::size_t i = 1; i < curve.diameter.size(); ++i) {
    const double mass = curve.passing[i] - curve.passing[i - 1];
    const double size = std::sqrt(curve.diameter[i] * curve.diameter[i - 1]);
    if (mass > 0.0 && size >= smallest && size < largest) number += mass / (size * size * size);
  }
  return number;
}

/// Particles at the end of packing.
double initial_number(const NumberTable& samples) {
  double number = 0.0;
  for (std::size_t row = 0; row < samples.rows(); ++row) {
    if (samples.at(row, "broken_total") > 0.0) break;
    number = samples.at(row, "particles");
  }
  return number;
}

}  // namespace

std::vector<BrokenFraction> broken_fractions(const JobResults& results) {
  const std::vector<Curve> curves = grading_curves(results.grading);
  const std::vector<double>& broken = results.breakages.column("diameter_m");
  const std::vector<double>& broken_at = results.breakages.column("creep_time_s");
  const double initial = initial_number(results.samples);
  if (curves.empty() || broken.empty() || broken_at.empty() || !(initial > 0.0)) return {};
  const double everything = number_between(curves.front(), 0.0, std::numeric_limits<double>::infinity());
  if (!(everything > 0.0)) return {};
  const double per_unit = initial / everything;

  const double low = *std::min_element(broken.begin(), broken.end()) * (1.0 - 1e-9);
  const double high = curves.front().diameter.back() * (1.0 + 1e-9);
  if (!(high > low) || !(low > 0.0)) return {};
  std::vector<BrokenFraction> classes;
  for (int i = 0; i < kClasses; ++i) {
    BrokenFraction one;
    one.smallest = low * std::pow(high / low, static_cast<double>(i) / kClasses);
    one.largest = low * std::pow(high / low, static_cast<double>(i + 1) / kClasses);
    for (const Curve& curve : curves) {
      if (!(curve.creep_time > 0.0)) continue;
      const double number = per_unit * number_between(curve, one.smallest, one.largest);
      double count = 0.0;
      for (std::size_t k = 0; k < broken.size(); ++k) {
        if (broken[k] >= one.smallest && broken[k] < one.largest && broken_at[k] <= curve.creep_time)
          count += 1.0;
      }
      // Below one particle the ratio says nothing.
      if (number < 1.0) continue;
      one.creep_time.push_back(curve.creep_time);
      one.fraction.push_back(count / number);
    }
    if (!one.creep_time.empty()) classes.push_back(one);
  }
  return classes;
}

}  // namespace creepctl
