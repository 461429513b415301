// Paints a laid-out chart on Cairo surfaces.
#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>

#include <cairo-svg.h>
#include <cairo.h>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "client/charts/chart.h"

namespace creepctl {
namespace {

constexpr Color kInk{0.13, 0.13, 0.13};
constexpr Color kMuted{0.38, 0.38, 0.38};
constexpr Color kGrid{0.88, 0.88, 0.88};
constexpr Color kFaintGrid{0.945, 0.945, 0.945};
constexpr Color kWhite{1.0, 1.0, 1.0};
constexpr double kTextSize = 12.5;
constexpr double kSmallSize = 11.0;
constexpr double kTitleSize = 14.5;
constexpr double kMarkerRadius = 4.2;
constexpr double kLegendRow = 18.0;
constexpr double kLegendPad = 9.0;
constexpr double kLegendKey = 34.0;
constexpr double kBarOpacity = 0.85;
constexpr double kBandOpacity = 0.18;
constexpr double kPixelsPerPoint = 2.0;  // of a PNG

Color color_of(Hue hue) {
  switch (hue) {
    case Hue::kBlack:
      return {0.0, 0.0, 0.0};
    case Hue::kBlue:
      return {0.0, 0.447, 0.698};
    case Hue::kOrange:
      return {0.902, 0.624, 0.0};
    case Hue::kGreen:
      return {0.0, 0.62, 0.451};
    case Hue::kVermilion:
      return {0.835, 0.369, 0.0};
    case Hue::kPurple:
      return {0.8, 0.475, 0.655};
    case Hue::kSky:
      return {0.337, 0.706, 0.914};
    case Hue::kGrey:
      return {0.5, 0.5, 0.5};
  }
  return kInk;
}

double x_at(const Chart& chart, const Layout& placed, double value) {
  return placed.plot.x + placed.plot.width * axis_position(chart.x.scale, placed.x_range, value);
}

double y_at(const Chart& chart, const Layout& placed, double value) {
  return placed.plot.y + placed.plot.height * (1.0 - axis_position(chart.y.scale, placed.y_range, value));
}

void draw_axes(Canvas& canvas, const Chart& chart, const Layout& placed) {
  const Box& plot = placed.plot;
  const double bottom = plot.y + plot.height;
  const double right = plot.x + plot.width;
  for (const Tick& tick : placed.x_ticks) {
    const double x = x_at(chart, placed, tick.value);
    const bool grid = !chart.x.whole_numbers && (tick.major || chart.x.scale == Scale::kLog);
    if (grid) canvas.line({{x, plot.y}, {x, bottom}}, tick.major ? kGrid : kFaintGrid, 0.8, Dash::kSolid);
  }
  for (const Tick& tick : placed.y_ticks) {
    const double y = y_at(chart, placed, tick.value);
    const bool grid = tick.major || chart.y.scale == Scale::kLog;
    if (grid) canvas.line({{plot.x, y}, {right, y}}, tick.major ? kGrid : kFaintGrid, 0.8, Dash::kSolid);
  }
  for (const Tick& tick : placed.x_ticks) {
    const double x = x_at(chart, placed, tick.value);
    canvas.line({{x, bottom}, {x, bottom + (tick.major ? 6.0 : 3.5)}}, kInk, 1.0, Dash::kSolid);
    canvas.text({x, bottom + 21.0}, tick.label, kTextSize, TextAlign::kCentre, kInk);
  }
  for (const Tick& tick : placed.y_ticks) {
    const double y = y_at(chart, placed, tick.value);
    canvas.line({{plot.x - (tick.major ? 6.0 : 3.5), y}, {plot.x, y}}, kInk, 1.0, Dash::kSolid);
    canvas.text({plot.x - 9.0, y + 4.5}, tick.label, kTextSize, TextAlign::kRight, kInk);
  }
  for (const Landmark& landmark : chart.landmarks) {
    const double x = x_at(chart, placed, landmark.x);
    if (x < plot.x - 0.5 || x > right + 0.5) continue;
    canvas.line({{x, plot.y - 5.0}, {x, plot.y}}, kMuted, 1.0, Dash::kSolid);
    canvas.text({x, plot.y - 9.0}, landmark.label, kSmallSize, TextAlign::kCentre, kMuted);
  }
  canvas.text({plot.x + 0.5 * plot.width, kChartHeight - 18.0}, chart.x.title, kTextSize + 1.0,
              TextAlign::kCentre, kInk);
  canvas.upward_text({20.0, plot.y + 0.5 * plot.height}, chart.y.title, kTextSize + 1.0, kInk);
  canvas.text({plot.x, 28.0}, chart.title, kTitleSize, TextAlign::kLeft, kInk, true);
}

void draw_bars(Canvas& canvas, const Chart& chart, const Layout& placed, std::size_t index) {
  const Box& plot = placed.plot;
  const double per_unit = plot.width / (placed.x_range.high - placed.x_range.low);
  const double width = std::clamp(0.62 * per_unit, 1.5, 46.0);
  const double base = y_at(chart, placed, std::max(0.0, placed.y_range.low));
  for (const PlacedPoint& point : placed.points[index]) {
    const double top = std::min(point.at.y, base);
    canvas.rectangle(point.at.x - 0.5 * width, top, width, std::fabs(base - point.at.y),
                     color_of(chart.series[index].hue), kBarOpacity);
  }
}

void draw_series(Canvas& canvas, const Chart& chart, const Layout& placed, std::size_t index) {
  const Series& series = chart.series[index];
  if (series.shape == Shape::kBand)
    return canvas.area(placed.paths[index], color_of(series.hue), kBandOpacity);
  if (series.shape == Shape::kBars) draw_bars(canvas, chart, placed, index);
  canvas.line(placed.paths[index], color_of(series.hue), series.line_width, series.dash);
  for (const PlacedPoint& point : placed.points[index]) {
    canvas.marker(point.at, series.marker, kMarkerRadius, color_of(series.hue));
  }
}

/// Labels up and left of their markers, where a rising curve leaves room; those that would touch are left
/// out.
void draw_point_labels(Canvas& canvas, const Layout& placed, const Series& series, std::size_t index) {
  if (series.point_labels.empty()) return;
  std::vector<Box> taken;
  for (const PlacedPoint& point : placed.points[index]) {
    const std::string& label = series.point_labels[point.index];
    const double width = canvas.text_width(label, kSmallSize);
    const Point at{std::max(point.at.x - 7.0 - width, placed.plot.x + 3.0),
                   std::max(point.at.y - 6.0, placed.plot.y + 11.0)};
    const Box box{at.x, at.y - kSmallSize, width + 3.0, kSmallSize + 2.0};
    const auto touches = [&](const Box& other) {
      return box.x < other.x + other.width && other.x < box.x + box.width && box.y < other.y + other.height &&
             other.y < box.y + box.height;
    };
    if (std::any_of(taken.begin(), taken.end(), touches)) continue;
    taken.push_back(box);
    canvas.text(at, label, kSmallSize, TextAlign::kLeft, kInk);
  }
}

void draw_levels(Canvas& canvas, const Chart& chart, const Layout& placed) {
  const Box& plot = placed.plot;
  for (const LevelLine& level : chart.levels) {
    const double y = y_at(chart, placed, level.y);
    canvas.line({{plot.x, y}, {plot.x + plot.width, y}}, color_of(Hue::kVermilion), 1.4, Dash::kDashed);
  }
}

void draw_legend_key(Canvas& canvas, const Series& series, double x, double y) {
  const Color color = color_of(series.hue);
  if (series.shape == Shape::kBars || series.shape == Shape::kBand) {
    const double opacity = series.shape == Shape::kBars ? kBarOpacity : kBandOpacity;
    canvas.rectangle(x + 5.0, y - 5.0, 16.0, 10.0, color, opacity);
    return;
  }
  if (series.stroke) canvas.line({{x, y}, {x + 26.0, y}}, color, series.line_width, series.dash);
  canvas.marker({x + 13.0, y}, series.marker, kMarkerRadius, color);
}

void draw_legend(Canvas& canvas, const Chart& chart, const Layout& placed) {
  double width = 0.0;
  std::size_t rows = 0;
  for (const Series& series : chart.series) {
    if (series.label.empty()) continue;
    width = std::max(width, kLegendKey + canvas.text_width(series.label, kSmallSize));
    ++rows;
  }
  for (const LevelLine& level : chart.levels) {
    width = std::max(width, kLegendKey + canvas.text_width(level.label, kSmallSize));
    ++rows;
  }
  for (const std::string& note : chart.notes) width = std::max(width, canvas.text_width(note, kSmallSize));
  if (rows + chart.notes.size() == 0) return;
  const double height = static_cast<double>(rows + chart.notes.size()) * kLegendRow + 2.0 * kLegendPad - 4.0;
  const Box box = place_box(placed, width + 2.0 * kLegendPad, height);
  canvas.rectangle(box.x, box.y, box.width, box.height, kWhite, 0.9);
  canvas.frame(box.x, box.y, box.width, box.height, kGrid, 0.8);
  double y = box.y + kLegendPad + 9.0;
  const double x = box.x + kLegendPad;
  for (const Series& series : chart.series) {
    if (series.label.empty()) continue;
    draw_legend_key(canvas, series, x, y - 4.0);
    canvas.text({x + kLegendKey, y}, series.label, kSmallSize, TextAlign::kLeft, kInk);
    y += kLegendRow;
  }
  for (const LevelLine& level : chart.levels) {
    canvas.line({{x, y - 4.0}, {x + 26.0, y - 4.0}}, color_of(Hue::kVermilion), 1.4, Dash::kDashed);
    canvas.text({x + kLegendKey, y}, level.label, kSmallSize, TextAlign::kLeft, kInk);
    y += kLegendRow;
  }
  for (const std::string& note : chart.notes) {
    canvas.text({x, y}, note, kSmallSize, TextAlign::kLeft, kInk);
    y += kLegendRow;
  }
}

void draw(cairo_t* context, const Chart& chart) {
  Canvas canvas(context);
  const Layout placed = layout(chart);
  canvas.rectangle(0.0, 0.0, kChartWidth, kChartHeight, kWhite, 1.0);
  draw_axes(canvas, chart, placed);
  canvas.push_clip(placed.plot.x - 1.0, placed.plot.y - 1.0, placed.plot.width + 2.0,
                   placed.plot.height + 2.0);
  for (std::size_t i = 0; i < chart.series.size(); ++i) draw_series(canvas, chart, placed, i);
  draw_levels(canvas, chart, placed);
  canvas.pop_clip();
  canvas.frame(placed.plot.x, placed.plot.y, placed.plot.width, placed.plot.height, kInk, 1.0);
  for (std::size_t i = 0; i < chart.series.size(); ++i) draw_point_labels(canvas, placed, chart.series[i], i);
  draw_legend(canvas, chart, placed);
}

cairo_status_t append(void* out, const unsigned char* bytes, unsigned int count) {
  static_cast<std::string*>(out)->append(reinterpret_cast<const char*>(bytes), count);
  return CAIRO_STATUS_SUCCESS;
}

void replace_all(std::string& text, const std::string& from, const std::string& to) {
  for (std::size_t at = text.find(from); at != std::string::npos; at = text.find(from, at + to.size())) {
    text.replace(at, from.size(), to);
  }
}

using Surface = std::unique_ptr<cairo_surface_t, decltype(&cairo_surface_destroy)>;
using Context = std::unique_ptr<cairo_t, decltype(&cairo_destroy)>;

}  // namespace

std::string draw_svg(const Chart& chart, const std::string& id_prefix) {
  std::string svg;
  {
    const Surface surface(cairo_svg_surface_create_for_stream(append, &svg, kChartWidth, kChartHeight),
                          cairo_surface_destroy);
    const Context context(cairo_create(surface.get()), cairo_destroy);
    draw(context.get(), chart);
    cairo_surface_finish(surface.get());
  }
  // Cairo names glyphs alike in every file.
  replace_all(svg, " id=\"", absl::StrCat(" id=\"", id_prefix));
  replace_all(svg, "xlink:href=\"#", absl::StrCat("xlink:href=\"#", id_prefix));
  replace_all(svg, "url(#", absl::StrCat("url(#", id_prefix));
  return svg;
}

absl::StatusOr<std::string> draw_png(const Chart& chart) {
  const Surface surface(
      cairo_image_surface_create(CAIRO_FORMAT_RGB24, static_cast<int>(kPixelsPerPoint * kChartWidth),
                                 static_cast<int>(kPixelsPerPoint * kChartHeight)),
      cairo_surface_destroy);
  const Context context(cairo_create(surface.get()), cairo_destroy);
  cairo_scale(context.get(), kPixelsPerPoint, kPixelsPerPoint);
  draw(context.get(), chart);
  std::string png;
  const cairo_status_t status = cairo_surface_write_to_png_stream(surface.get(), append, &png);
  if (status != CAIRO_STATUS_SUCCESS) {
    return absl::InternalError(absl::StrCat("cannot draw the PNG: ", cairo_status_to_string(status)));
  }
  return png;
}

}  // namespace creepctl
