#include "client/charts/chart.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/arithmetic/check.h"

namespace creepctl {
namespace {

constexpr double kLeftMargin = 92.0;
constexpr double kRightMargin = 24.0;
constexpr double kTopMargin = 48.0;
constexpr double kLandmarkMargin = 20.0;
constexpr double kBottomMargin = 66.0;

std::vector<Tick> whole_number_ticks(AxisRange range, int most_labels) {
  const double span = range.high - range.low;
  long step = 1;
  while (span / static_cast<double>(step) > most_labels) {
    const bool two = step % 10 == 2 || step % 100 == 20 || step % 1000 == 200;
    step = two ? step / 2 * 5 : step * 2;
  }
  std::vector<Tick> ticks;
  for (long value = static_cast<long>(std::ceil(range.low)); static_cast<double>(value) <= range.high;
       ++value) {
    if (value % step == 0) ticks.push_back({static_cast<double>(value), std::to_string(value), true});
  }
  return ticks;
}

AxisRange choose_range(const Axis& axis, const std::vector<double>& values) {
  const AxisRange fallback = axis.scale == Scale::kLog ? AxisRange{1.0, 10.0} : AxisRange{0.0, 1.0};
  const auto data = data_range(axis.scale, values);
  AxisRange range = data ? axis_range(axis.scale, *data) : fallback;
  if (axis.whole_numbers && data) range = {std::floor(data->low) - 0.7, std::ceil(data->high) + 0.7};
  if (axis.low) range.low = *axis.low;
  if (axis.high) range.high = *axis.high;
  if (!(range.high > range.low)) range.high = axis.scale == Scale::kLog ? 10.0 * range.low : range.low + 1.0;
  return range;
}

std::vector<Point> path_of(const Series& series, const std::vector<PlacedPoint>& points) {
  std::vector<Point> path;
  if (series.shape == Shape::kBars || !series.stroke) return path;
  for (const PlacedPoint& point : points) {
    if (series.shape == Shape::kStairs && !path.empty()) path.push_back({point.at.x, path.back().y});
    path.push_back(point.at);
  }
  return path;
}

}  // namespace

bool Box::contains(Point point) const {
  return point.x >= x && point.x <= x + width && point.y >= y && point.y <= y + height;
}

Point Layout::place(Scale x_scale, Scale y_scale, double x, double y) const {
  return {plot.x + plot.width * axis_position(x_scale, x_range, x),
          plot.y + plot.height * (1.0 - axis_position(y_scale, y_range, y))};
}

Layout layout(const Chart& chart) {
  std::vector<double> all_x;
  std::vector<double> all_y;
  for (const Series& series : chart.series) {
    CREEP_CHECK(series.x.size() == series.y.size(), "series with unequal x and y");
    CREEP_CHECK(series.point_labels.empty() || series.point_labels.size() == series.x.size(),
                "labels not per point");
    for (std::size_t i = 0; i < series.x.size(); ++i) {
      // A value lost on one axis must not stretch the other.
      if (!drawable(chart.x.scale, series.x[i]) || !drawable(chart.y.scale, series.y[i])) continue;
      all_x.push_back(series.x[i]);
      all_y.push_back(series.y[i]);
    }
    if (series.shape == Shape::kBars && chart.y.scale == Scale::kLinear) all_y.push_back(0.0);
  }
  for (const LevelLine& level : chart.levels) all_y.push_back(level.y);

  Layout out;
  const double top = kTopMargin + (chart.landmarks.empty() ? 0.0 : kLandmarkMargin);
  out.plot = {kLeftMargin, top, kChartWidth - kLeftMargin - kRightMargin, kChartHeight - top - kBottomMargin};
  out.x_range = choose_range(chart.x, all_x);
  out.y_range = choose_range(chart.y, all_y);
  out.x_ticks = chart.x.whole_numbers
                    ? whole_number_ticks(out.x_range, 16)
                    : axis_ticks(chart.x.scale, out.x_range, chart.x.scale == Scale::kLog ? 13 : 10);
  out.y_ticks = axis_ticks(chart.y.scale, out.y_range, chart.y.scale == Scale::kLog ? 13 : 10);
  for (const Series& series : chart.series) {
    std::vector<PlacedPoint> points;
    for (std::size_t i = 0; i < series.x.size(); ++i) {
      if (!drawable(chart.x.scale, series.x[i]) || !drawable(chart.y.scale, series.y[i])) continue;
      points.push_back({out.place(chart.x.scale, chart.y.scale, series.x[i], series.y[i]), i});
    }
    if (series.shape == Shape::kBars) {
      for (const PlacedPoint& point : points) {
        constexpr double kStep = 8.0;
        const double depth = out.plot.y + out.plot.height - point.at.y;
        for (int step = 0; kStep * step < depth; ++step) {
          out.bar_bodies.push_back({point.at.x, point.at.y + kStep * step});
        }
      }
    }
    out.paths.push_back(path_of(series, points));
    out.points.push_back(std::move(points));
  }
  return out;
}

Box place_box(const Layout& layout, double width, double height) {
  constexpr double kGap = 12.0;
  const Box& plot = layout.plot;
  std::vector<Point> ink = layout.bar_bodies;
  for (const auto& points : layout.points) {
    for (const PlacedPoint& point : points) ink.push_back(point.at);
  }
  for (const auto& path : layout.paths) {
    for (std::size_t i = 1; i < path.size(); ++i) {
      const double length = std::hypot(path[i].x - path[i - 1].x, path[i].y - path[i - 1].y);
      const int pieces = 1 + static_cast<int>(std::min(length, 2000.0) / 8.0);
      for (int k = 0; k < pieces; ++k) {
        const double part = static_cast<double>(k) / pieces;
        ink.push_back({path[i - 1].x + part * (path[i].x - path[i - 1].x),
                       path[i - 1].y + part * (path[i].y - path[i - 1].y)});
      }
    }
  }
  const double right = plot.x + plot.width - width - kGap;
  const double bottom = plot.y + plot.height - height - kGap;
  const double xs[] = {plot.x + kGap, right, 0.5 * (plot.x + kGap + right)};
  const double ys[] = {plot.y + kGap, bottom, 0.5 * (plot.y + kGap + bottom)};
  Box best{xs[0], ys[0], width, height};
  std::ptrdiff_t least = -1;
  for (const double x : xs) {
    for (const double y : ys) {
      const Box wider{x - 6.0, y - 6.0, width + 12.0, height + 12.0};
      const auto hidden =
          std::count_if(ink.begin(), ink.end(), [&](Point point) { return wider.contains(point); });
      if (least >= 0 && hidden >= least) continue;
      least = hidden;
      best = {x, y, width, height};
    }
  }
  return best;
}

}  // namespace creepctl
