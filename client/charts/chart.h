// Charts: curves, markers and bars between two axes, drawn alike to SVG and PNG.
//
// A Chart is plain data; layout() turns it into geometry (testable without pictures), draw_svg/draw_png paint
// it. Values that an axis cannot hold (NaN, or not positive on a log axis) are left out of the drawing.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "client/charts/axis.h"
#include "client/charts/canvas.h"

namespace creepctl {

/// The points of a kBand run around an area, which is tinted.
enum class Shape { kLine, kStairs, kBars, kBand };

/// Hues apart for all common kinds of colour blindness (Okabe & Ito 2008).
enum class Hue { kBlack, kBlue, kOrange, kGreen, kVermilion, kPurple, kSky, kGrey };

struct Series {
  std::string label;  ///< "" keeps it out of the legend
  std::vector<double> x;
  std::vector<double> y;  ///< as long as x
  Hue hue = Hue::kBlue;
  Shape shape = Shape::kLine;
  bool stroke = true;  ///< draw the line itself
  Dash dash = Dash::kSolid;
  double line_width = 1.8;
  Marker marker = Marker::kNone;
  std::vector<std::string>
      point_labels{};  ///< beside the markers, while there is room; empty or as long as x
};

struct Axis {
  std::string title;  ///< with the unit: "creep time (s)"
  Scale scale = Scale::kLinear;
  std::optional<double> low;  ///< fixed ends; else from the data
  std::optional<double> high;
  bool whole_numbers = false;  ///< ticks at integers only
};

/// A name for a place on the x axis, written along the top: "1 h" at 3600 s.
struct Landmark {
  double x = 0.0;
  std::string label;
};

/// A dashed line across the plot at a y value, named in the legend.
struct LevelLine {
  double y = 0.0;
  std::string label;
};

struct Chart {
  std::string title;
  Axis x;
  Axis y;
  std::vector<Series> series;
  std::vector<Landmark> landmarks;
  std::vector<LevelLine> levels;
  std::vector<std::string> notes;  ///< lines under the legend, e.g. the figures of a fit
};

inline constexpr double kChartWidth = 800.0;
inline constexpr double kChartHeight = 560.0;

struct Box {
  double x = 0.0;
  double y = 0.0;
  double width = 0.0;
  double height = 0.0;
  bool contains(Point point) const;
};

/// A value of a series on the page.
struct PlacedPoint {
  Point at;
  std::size_t index = 0;  ///< in the series
};

/// Where things come to lie on the page.
struct Layout {
  Box plot;  ///< inside the axes
  AxisRange x_range;
  AxisRange y_range;
  std::vector<Tick> x_ticks;
  std::vector<Tick> y_ticks;
  std::vector<std::vector<PlacedPoint>> points;  ///< per series, without the values the axes cannot hold
  std::vector<std::vector<Point>> paths;         ///< per series, the line through its points; empty for bars

  std::vector<Point> bar_bodies;  ///< points along all bars, for what must not cover them

  Point place(Scale x_scale, Scale y_scale, double x, double y) const;
};

Layout layout(const Chart& chart);

/// Of the places a box of that size can take inside the plot, the one that hides the least of the data.
Box place_box(const Layout& layout, double width, double height);

/// A whole SVG file. Ids in it begin with `id_prefix`, so that several can share one page.
std::string draw_svg(const Chart& chart, const std::string& id_prefix);

/// A PNG of twice as many pixels as the chart has points. Error: Internal from Cairo.
absl::StatusOr<std::string> draw_png(const Chart& chart);

}  // namespace creepctl
