#include "client/results/mean_curve.h"

#include <algorithm>
#include <cmath>

#include "core/analysis/ensemble_mean.h"

namespace creepctl {
namespace {

constexpr int kPieces = 120;

/// With ln x, and ln y if wanted; without points that have none, or that do not advance x.
Curve in_logarithms(const Curve& curve, MeanOf what) {
  Curve out;
  for (std::size_t i = 0; i < curve.x.size(); ++i) {
    if (!(curve.x[i] > 0.0) || !std::isfinite(curve.y[i])) continue;
    if (what == MeanOf::kLogarithms && !(curve.y[i] > 0.0)) continue;
    const double x = std::log(curve.x[i]);
    if (!out.x.empty() && !(x > out.x.back())) continue;
    out.x.push_back(x);
    out.y.push_back(what == MeanOf::kLogarithms ? std::log(curve.y[i]) : curve.y[i]);
  }
  return out;
}

double value_at(const Curve& curve, double x) {
  const auto after = std::upper_bound(curve.x.begin(), curve.x.end(), x);
  const auto i = static_cast<std::size_t>(std::clamp<std::ptrdiff_t>(
      after - curve.x.begin(), 1, static_cast<std::ptrdiff_t>(curve.x.size()) - 1));
  const double part = (x - curve.x[i - 1]) / (curve.x[i] - curve.x[i - 1]);
  return curve.y[i - 1] + std::clamp(part, 0.0, 1.0) * (curve.y[i] - curve.y[i - 1]);
}

}  // namespace

std::optional<MeanCurve> mean_curve(const std::vector<Curve>& curves, MeanOf what) {
  std::vector<Curve> logs;
  for (const Curve& curve : curves) {
    Curve log = in_logarithms(curve, what);
    if (log.x.size() >= 2) logs.push_back(std::move(log));
  }
  if (logs.empty()) return std::nullopt;
  double begin = logs.front().x.front(), end = logs.front().x.back();
  for (const Curve& log : logs) {
    begin = std::max(begin, log.x.front());
    end = std::min(end, log.x.back());
  }
  if (!(end > begin)) return std::nullopt;
  std::vector<double> places = logs.front().x;
  if (logs.size() > 1) {
    places.clear();
    for (int i = 0; i <= kPieces; ++i) places.push_back(begin + (end - begin) * i / kPieces);
  }
  const auto back = [&](double value) { return what == MeanOf::kLogarithms ? std::exp(value) : value; };
  MeanCurve out;
  out.count = logs.size();
  for (const double place : places) {
    std::vector<double> values;
    for (const Curve& log : logs) values.push_back(value_at(log, place));
    const auto mean = creep::ensemble_mean(values);
    out.x.push_back(std::exp(place));
    out.mean.push_back(back(mean->mean));
    if (!mean->half_width) continue;
    out.low.push_back(back(mean->low()));
    out.high.push_back(back(mean->high()));
  }
  return out;
}

}  // namespace creepctl
