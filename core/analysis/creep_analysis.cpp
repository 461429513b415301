#include "core/analysis/creep_analysis.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/arithmetic/check.h"

namespace creep {
namespace {

constexpr std::size_t kFewestPoints = 3;   // of a regression
constexpr std::size_t kLeastWindow = 3;    // intervals a smoothed rate spans at least
constexpr double kLeastWindowRatio = 2.0;  // and the creep_time ratio it spans at least
constexpr double kLeastRateRatio = 2.0;    // creep_time ratio between the points of a rate
constexpr double kSameRate = 1.25;         // rates within this factor count as constant
constexpr double kRise = 2.0;          // a rise of the smoothed rate that noise of 40 % a stage does not make
constexpr double kSignificance = 2.0;  // standard deviations
constexpr double kLeastPlateau = 2.0;  // creep_time ratio a constant rate must last to be secondary creep

/// Points with a logarithm that advance creep_time.
CreepCurve usable(const CreepCurve& curve) {
  CREEP_CHECK(curve.creep_time.size() == curve.axial_strain.size(),
              "creep curve with arrays of unequal length");
  CreepCurve out;
  for (std::size_t i = 0; i < curve.creep_time.size(); ++i) {
    const double creep_time = curve.creep_time[i];
    const bool finite = std::isfinite(creep_time) && std::isfinite(curve.axial_strain[i]);
    const bool advances = out.creep_time.empty() || creep_time > out.creep_time.back();
    if (!finite || creep_time <= 0.0) continue;
    if (!advances) {
      // The later row of equal creep_time is the later state.
      if (creep_time == out.creep_time.back()) out.axial_strain.back() = curve.axial_strain[i];
      continue;
    }
    out.creep_time.push_back(creep_time);
    out.axial_strain.push_back(curve.axial_strain[i]);
  }
  return out;
}

/// Every point at least kLeastRateRatio behind the one before it, and the last.
CreepCurve spread(const CreepCurve& points) {
  CreepCurve out;
  for (std::size_t i = 0; i < points.creep_time.size(); ++i) {
    const bool far =
        out.creep_time.empty() || points.creep_time[i] >= kLeastRateRatio * out.creep_time.back();
    if (!far && i + 1 < points.creep_time.size()) continue;
    if (!far && out.creep_time.size() > 1) {
      out.creep_time.pop_back();
      out.axial_strain.pop_back();
    }
    out.creep_time.push_back(points.creep_time[i]);
    out.axial_strain.push_back(points.axial_strain[i]);
  }
  return out;
}

/// Rate between two points of the curve.
StrainRate rate_between(const CreepCurve& points, std::size_t first, std::size_t last) {
  const double begin = points.creep_time[first];
  const double end = points.creep_time[last];
  const double middle = std::sqrt(begin) * std::sqrt(end);
  const double strain = points.axial_strain[last] - points.axial_strain[first];
  return {middle, strain / std::log(end / begin) / middle};
}

std::vector<StrainRate> between_neighbours(const CreepCurve& points) {
  std::vector<StrainRate> rates;
  for (std::size_t i = 1; i < points.creep_time.size(); ++i) rates.push_back(rate_between(points, i - 1, i));
  return rates;
}

struct Line {
  double intercept = 0.0;
  double slope = 0.0;
  double slope_standard_error = 0.0;
  double scatter = 0.0;  // standard deviation about the line
  std::optional<double> r_squared;
};

/// Least squares about the mean, which keeps the sums small. nullopt with fewer than 3 points or equal
/// abscissae.
std::optional<Line> fit_line(const std::vector<double>& abscissa, const std::vector<double>& ordinate) {
  const std::size_t count = abscissa.size();
  if (count < kFewestPoints) return std::nullopt;
  double mean_x = 0.0;
  double mean_y = 0.0;
  for (std::size_t i = 0; i < count; ++i) {
    mean_x += abscissa[i];
    mean_y += ordinate[i];
  }
  mean_x /= static_cast<double>(count);
  mean_y /= static_cast<double>(count);
  double xx = 0.0;
  double xy = 0.0;
  double yy = 0.0;
  for (std::size_t i = 0; i < count; ++i) {
    xx += (abscissa[i] - mean_x) * (abscissa[i] - mean_x);
    xy += (abscissa[i] - mean_x) * (ordinate[i] - mean_y);
    yy += (ordinate[i] - mean_y) * (ordinate[i] - mean_y);
  }
  if (xx <= 0.0) return std::nullopt;
  Line line;
  line.slope = xy / xx;
  line.intercept = mean_y - line.slope * mean_x;
  double residual = 0.0;
  for (std::size_t i = 0; i < count; ++i) {
    const double miss = ordinate[i] - line.intercept - line.slope * abscissa[i];
    residual += miss * miss;
  }
  line.scatter = std::sqrt(residual / static_cast<double>(count - 2));
  line.slope_standard_error = line.scatter / std::sqrt(xx);
  // Below this spread the ordinates are equal to rounding, and a ratio of roundings is no correlation.
  const double rounding = 1e-14 * (1.0 + std::fabs(mean_y));
  if (yy > static_cast<double>(count) * rounding * rounding) line.r_squared = 1.0 - residual / yy;
  return line;
}

/// The run of smoothed rates about the least one in which they stay within kSameRate of it.
struct Plateau {
  std::size_t least = 0;
  std::size_t first = 0;
  std::size_t last = 0;
};

std::optional<Plateau> find_plateau(const std::vector<StrainRate>& rates) {
  std::optional<Plateau> found;
  for (std::size_t i = 0; i < rates.size(); ++i) {
    if (rates[i].rate <= 0.0) continue;
    if (!found || rates[i].rate < rates[found->least].rate) found = Plateau{i, i, i};
  }
  if (!found) return std::nullopt;
  const double limit = kSameRate * rates[found->least].rate;
  while (found->first > 0 && rates[found->first - 1].rate <= limit) --found->first;
  while (found->last + 1 < rates.size() && rates[found->last + 1].rate <= limit) ++found->last;
  return found;
}

/// How many times its minimum a smoothed rate must become to be more than scatter. A window averages at least
/// kLeastWindow intervals.
double significant_rise(const std::optional<SinghMitchellFit>& before) {
  if (!before) return kRise;
  const double deviation = before->ln_rate_scatter / std::sqrt(static_cast<double>(kLeastWindow));
  return std::max(kRise, std::exp(kSignificance * deviation));
}

}  // namespace

std::vector<StrainRate> strain_rates(const CreepCurve& curve) {
  return between_neighbours(spread(usable(curve)));
}

std::vector<StrainRate> smoothed_strain_rates(const CreepCurve& curve) {
  const CreepCurve points = usable(curve);
  std::vector<StrainRate> rates;
  std::size_t first = 0;  // of the shortest window that ends at `last` and is wide enough
  for (std::size_t last = kLeastWindow; last < points.creep_time.size(); ++last) {
    const double latest_begin = points.creep_time[last] / kLeastWindowRatio;
    if (points.creep_time.front() > latest_begin) continue;
    while (first + 1 + kLeastWindow <= last && points.creep_time[first + 1] <= latest_begin) ++first;
    rates.push_back(rate_between(points, first, last));
  }
  return rates;
}

double SinghMitchellFit::rate(double creep_time) const {
  return std::exp(ln_rate_at_1_s - m * std::log(creep_time));
}

std::optional<SinghMitchellFit> fit_singh_mitchell(const std::vector<StrainRate>& rates, double window_begin,
                                                   double window_end) {
  SinghMitchellFit fit;
  std::vector<double> ln_creep_time;
  std::vector<double> ln_rate;
  for (const StrainRate& point : rates) {
    if (point.creep_time < window_begin || point.creep_time > window_end) continue;
    if (point.rate <= 0.0) {
      ++fit.omitted;
      continue;
    }
    if (ln_rate.empty()) fit.window_begin = point.creep_time;
    fit.window_end = point.creep_time;
    ln_creep_time.push_back(std::log(point.creep_time));
    ln_rate.push_back(std::log(point.rate));
  }
  const std::optional<Line> line = fit_line(ln_creep_time, ln_rate);
  if (!line) return std::nullopt;
  fit.m = -line->slope;
  fit.m_standard_error = line->slope_standard_error;
  fit.r_squared = line->r_squared;
  fit.ln_rate_scatter = line->scatter;
  fit.ln_rate_at_1_s = line->intercept;
  fit.points = ln_rate.size();
  return fit;
}

std::optional<LogTimeFit> fit_log_time(const CreepCurve& curve) {
  const CreepCurve points = usable(curve);
  std::vector<double> decades;
  for (const double creep_time : points.creep_time) decades.push_back(std::log10(creep_time));
  const std::optional<Line> line = fit_line(decades, points.axial_strain);
  if (!line) return std::nullopt;
  return LogTimeFit{line->slope, line->intercept, line->r_squared, decades.size()};
}

CreepAnalysis analyse_creep(const CreepCurve& curve) {
  CreepAnalysis analysis;
  analysis.rates = strain_rates(curve);
  analysis.smoothed_rates = smoothed_strain_rates(curve);
  analysis.log_time_fit = fit_log_time(curve);

  const std::vector<StrainRate>& smooth = analysis.smoothed_rates;
  double primary_end = std::numeric_limits<double>::infinity();
  if (const auto plateau = find_plateau(smooth); plateau) {
    const StrainRate& least = smooth[plateau->least];
    const double earliest = smooth[plateau->first].creep_time;
    const double latest = smooth[plateau->last].creep_time;
    const double rise =
        significant_rise(fit_singh_mitchell(between_neighbours(usable(curve)), 0.0, earliest));
    const auto rose = [&](const StrainRate& point) { return point.rate >= rise * least.rate; };
    const auto after = smooth.begin() + static_cast<std::ptrdiff_t>(plateau->least);
    if (std::any_of(after, smooth.end(), rose)) {
      analysis.phase = CreepPhase::kTertiary;
      // The plateau ends somewhere between its last member and the next one, which the range includes.
      const std::size_t before = plateau->first == 0 ? 0 : plateau->first - 1;
      const std::size_t behind = std::min(plateau->last + 1, smooth.size() - 1);
      analysis.tertiary =
          TertiaryOnset{least.creep_time, smooth[before].creep_time, smooth[behind].creep_time, least.rate};
      primary_end = earliest;
    } else if (plateau->last + 1 == smooth.size() && latest >= kLeastPlateau * earliest) {
      analysis.phase = CreepPhase::kSecondary;
      primary_end = earliest;
    } else {
      analysis.phase = CreepPhase::kPrimary;
    }
  }
  analysis.primary_fit = fit_singh_mitchell(analysis.rates, 0.0, primary_end);
  return analysis;
}

}  // namespace creep
