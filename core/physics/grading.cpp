#include "core/physics/grading.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "core/arithmetic/check.h"
#include "core/arithmetic/elementary.h"

namespace creep {
namespace {

/// A lognormal cut at both ends, by mass (moment 0) or by number (moment 3): dividing a lognormal density of
/// ln d by d^3 shifts its mean by -3 sigma^2 and leaves its width and its ends.
struct CutLognormal {
  CutLognormal(const LognormalGrading& grading, double moment)
      : mean(elementary::log(grading.median_diameter) -
             moment * grading.log_standard_deviation * grading.log_standard_deviation),
        deviation(grading.log_standard_deviation),
        min_diameter(grading.min_diameter),
        max_diameter(grading.max_diameter),
        below(cumulative(grading.min_diameter)),
        inside(cumulative(grading.max_diameter) - below) {}

  double cumulative(double diameter) const {
    return elementary::normal_cdf((elementary::log(diameter) - mean) / deviation);
  }
  double fraction_below(double diameter) const {
    return std::clamp((cumulative(diameter) - below) / inside, 0.0, 1.0);
  }
  double quantile(double fraction) const {
    const double z = elementary::inverse_normal_cdf(std::min(1.0, below + fraction * inside));
    return std::clamp(elementary::exp(mean + deviation * z), min_diameter, max_diameter);
  }

  double mean;
  double deviation;
  double min_diameter;
  double max_diameter;
  double below;
  double inside;
};

double inverse_cube(double d) { return 1.0 / (d * d * d); }

/// Number of particles per total mass (up to a constant) in the segment that ends at points[i]: the mass
/// density in ln d is constant in it, the number density that over d^3.
double segment_number(const std::vector<GradingPoint>& points, std::size_t i) {
  const GradingPoint& a = points[i - 1];
  const GradingPoint& b = points[i];
  const double density = (b.passing - a.passing) / elementary::log(b.diameter / a.diameter);
  return density / 3.0 * (inverse_cube(a.diameter) - inverse_cube(b.diameter));
}

double total_number(const std::vector<GradingPoint>& points) {
  double number = 0.0;
  for (std::size_t i = 1; i < points.size(); ++i) number += segment_number(points, i);
  return number;
}

std::vector<double> diameters_of_points(const std::vector<GradingPoint>& points, std::int64_t count) {
  std::vector<double> diameters;
  diameters.reserve(static_cast<std::size_t>(count));
  const double per_particle = total_number(points) / static_cast<double>(count);
  double before = 0.0;  // number in the segments already passed
  std::size_t segment = 1;
  double inside = segment_number(points, segment);
  for (std::int64_t i = 0; i < count; ++i) {
    const double wanted = per_particle * (static_cast<double>(i) + 0.5);
    while (wanted > before + inside && segment + 1 < points.size()) {
      before += inside;
      inside = segment_number(points, ++segment);
    }
    // N(d) = inside (a^-3 - d^-3)/(a^-3 - b^-3) solved for d.
    const double a = points[segment - 1].diameter;
    const double b = points[segment].diameter;
    const double share = inside > 0.0 ? std::clamp((wanted - before) / inside, 0.0, 1.0) : 1.0;
    const double cube = 1.0 / (inverse_cube(a) - share * (inverse_cube(a) - inverse_cube(b)));
    diameters.push_back(std::clamp(elementary::pow(cube, 1.0 / 3.0), a, b));
  }
  return diameters;
}

void check_points(const std::vector<GradingPoint>& points) {
  CREEP_CHECK(points.size() >= 2, "a grading needs two points");
  CREEP_CHECK(points.front().passing == 0.0 && points.back().passing == 1.0, "a grading goes from 0 to 1");
  for (std::size_t i = 1; i < points.size(); ++i) {
    CREEP_CHECK(points[i].diameter > points[i - 1].diameter && points[i].passing >= points[i - 1].passing,
                "a grading rises");
  }
}

/// Integral over ln d, from `start` on, of a curve that is straight in ln d between the diameters and level
/// before them.
template <typename Ordinate>
double area_above(std::span<const double> diameters, double start, Ordinate ordinate) {
  if (diameters.empty()) return 0.0;
  double area = diameters.front() > start ? ordinate(0) * elementary::log(diameters.front() / start) : 0.0;
  for (std::size_t i = 1; i < diameters.size(); ++i) {
    if (diameters[i] <= start) continue;
    const double width = elementary::log(diameters[i] / diameters[i - 1]);
    const double cut =
        std::max(0.0, elementary::log(start / diameters[i - 1]) / width);  // share left of start
    const double left = ordinate(i - 1) + cut * (ordinate(i) - ordinate(i - 1));
    area += 0.5 * (left + ordinate(i)) * (1.0 - cut) * width;
  }
  return area;
}

}  // namespace

double passing_at_diameter(const Grading& grading, double diameter) {
  if (diameter <= finest_diameter(grading)) return 0.0;
  if (diameter >= coarsest_diameter(grading)) return 1.0;
  if (const auto* lognormal = std::get_if<LognormalGrading>(&grading)) {
    return CutLognormal(*lognormal, 0.0).fraction_below(diameter);
  }
  const auto& points = std::get<GradingPoints>(grading).points;
  std::size_t i = 1;
  while (points[i].diameter < diameter) ++i;
  const GradingPoint& a = points[i - 1];
  const GradingPoint& b = points[i];
  const double share = elementary::log(diameter / a.diameter) / elementary::log(b.diameter / a.diameter);
  return a.passing + share * (b.passing - a.passing);
}

double diameter_at_passing(const Grading& grading, double passing) {
  if (passing <= 0.0) return finest_diameter(grading);
  if (passing >= 1.0) return coarsest_diameter(grading);
  if (const auto* lognormal = std::get_if<LognormalGrading>(&grading)) {
    return CutLognormal(*lognormal, 0.0).quantile(passing);
  }
  const auto& points = std::get<GradingPoints>(grading).points;
  std::size_t i = 1;
  while (points[i].passing < passing) ++i;
  const GradingPoint& a = points[i - 1];
  const GradingPoint& b = points[i];
  const double share = (passing - a.passing) / (b.passing - a.passing);
  return a.diameter * elementary::pow(b.diameter / a.diameter, share);
}

double finest_diameter(const Grading& grading) {
  if (const auto* lognormal = std::get_if<LognormalGrading>(&grading)) return lognormal->min_diameter;
  const auto& points = std::get<GradingPoints>(grading).points;
  check_points(points);
  return points.front().diameter;
}

double coarsest_diameter(const Grading& grading) {
  if (const auto* lognormal = std::get_if<LognormalGrading>(&grading)) return lognormal->max_diameter;
  const auto& points = std::get<GradingPoints>(grading).points;
  check_points(points);
  return points.back().diameter;
}

double median_diameter(const Grading& grading) { return diameter_at_passing(grading, 0.5); }

double mean_cubed_diameter(const Grading& grading) {
  if (const auto* lognormal = std::get_if<LognormalGrading>(&grading)) {
    // Mass 1 divided by the number that makes it up, the mean of d^-3 by mass.
    const double variance = lognormal->log_standard_deviation * lognormal->log_standard_deviation;
    const double uncut = elementary::exp(3.0 * elementary::log(lognormal->median_diameter) - 4.5 * variance);
    return uncut * CutLognormal(*lognormal, 0.0).inside / CutLognormal(*lognormal, 3.0).inside;
  }
  const auto& points = std::get<GradingPoints>(grading).points;
  check_points(points);
  return 1.0 / total_number(points);
}

std::vector<double> stratified_diameters(const Grading& grading, std::int64_t count) {
  CREEP_CHECK(count >= 1, "a specimen without particles");
  if (const auto* points = std::get_if<GradingPoints>(&grading)) {
    check_points(points->points);
    return diameters_of_points(points->points, count);
  }
  const CutLognormal by_number(std::get<LognormalGrading>(grading), 3.0);
  std::vector<double> diameters;
  diameters.reserve(static_cast<std::size_t>(count));
  for (std::int64_t i = 0; i < count; ++i) {
    diameters.push_back(by_number.quantile((static_cast<double>(i) + 0.5) / static_cast<double>(count)));
  }
  return diameters;
}

double fractal_passing(double diameter, double max_diameter, double min_diameter, double a) {
  if (diameter >= max_diameter) return 1.0;
  if (diameter <= min_diameter) return 0.0;
  const double part = elementary::log(diameter / min_diameter);
  const double whole = elementary::log(max_diameter / min_diameter);
  if (std::fabs(a * whole) < 1e-8) return part / whole;
  return (elementary::exp(a * part) - 1.0) / (elementary::exp(a * whole) - 1.0);
}

GradingIndex::GradingIndex(const Material& material)
    : min_diameter_(material.grading_index_min_diameter),
      max_diameter_(material.grading_index_max_diameter),
      exponent_(3.0 - material.fractal_dimension) {
  CREEP_CHECK(min_diameter_ > 0.0 && min_diameter_ < max_diameter_,
              "limits of the grading index out of order");
}

double GradingIndex::particle_area(double diameter) const {
  return elementary::log(max_diameter_ / std::clamp(diameter, min_diameter_, max_diameter_));
}

double GradingIndex::fines_area(double smallest_sibling_diameter) const {
  if (smallest_sibling_diameter <= min_diameter_) return particle_area(min_diameter_);
  // Integral of the fractal passing over ln d up to the end of the fines or of the axis: with l =
  // ln(end/d_min),
  // ((e^(a l) - 1)/a - l) / (e^(a L) - 1), L the same for the end of the fines. Then 1 up to d_max.
  const double whole = elementary::log(smallest_sibling_diameter / min_diameter_);
  const double length = elementary::log(std::min(smallest_sibling_diameter, max_diameter_) / min_diameter_);
  const double coarser = particle_area(smallest_sibling_diameter);
  const double x = exponent_ * length;
  if (std::fabs(exponent_ * whole) < 1e-4) {
    // The same to first order in a, without 0/0.
    return coarser + 0.5 * length * length / whole * (1.0 + x / 3.0 - 0.5 * exponent_ * whole);
  }
  return coarser +
         ((elementary::exp(x) - 1.0) / exponent_ - length) / (elementary::exp(exponent_ * whole) - 1.0);
}

double breakage_hardin(std::span<const double> diameters, std::span<const double> initial,
                       std::span<const double> current) {
  constexpr double kSilt = 0.074e-3;
  CREEP_CHECK(initial.size() == diameters.size() && current.size() == diameters.size(),
              "curves of unequal length");
  const double potential = area_above(diameters, kSilt, [&](std::size_t i) { return 1.0 - initial[i]; });
  const double total = area_above(diameters, kSilt, [&](std::size_t i) { return current[i] - initial[i]; });
  return potential > 0.0 ? total / potential : 0.0;
}

double breakage_einav(std::span<const double> diameters, std::span<const double> initial,
                      std::span<const double> current, std::span<const double> ultimate) {
  CREEP_CHECK(initial.size() == diameters.size() && current.size() == diameters.size() &&
                  ultimate.size() == diameters.size(),
              "curves of unequal length");
  const double start = diameters.empty() ? 0.0 : diameters.front();
  const double possible =
      area_above(diameters, start, [&](std::size_t i) { return ultimate[i] - initial[i]; });
  const double total = area_above(diameters, start, [&](std::size_t i) { return current[i] - initial[i]; });
  return possible != 0.0 ? total / possible : 0.0;
}

}  // namespace creep
