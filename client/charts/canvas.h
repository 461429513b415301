// A drawing surface: the few strokes and texts a chart needs, on Cairo. Lengths in points, origin at the top
// left.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include <cairo.h>

namespace creepctl {

struct Color {
  double red = 0.0;
  double green = 0.0;
  double blue = 0.0;
};

struct Point {
  double x = 0.0;
  double y = 0.0;
};

enum class TextAlign { kLeft, kCentre, kRight };
enum class Dash { kSolid, kDashed, kDotted };
enum class Marker { kNone, kCircle, kSquare, kDiamond, kStar };

/// Draws on a Cairo context that it does not own.
class Canvas {
 public:
  explicit Canvas(cairo_t* context) : context_(context) {}

  void rectangle(double x, double y, double width, double height, Color fill, double opacity);
  void area(const std::vector<Point>& corners, Color fill, double opacity);
  void frame(double x, double y, double width, double height, Color stroke, double line_width);
  void line(const std::vector<Point>& points, Color stroke, double line_width, Dash dash);
  void marker(Point at, Marker marker, double radius, Color fill);

  /// Text with raised "^{...}" and lowered "_{...}" parts; `at` is on the baseline.
  void text(Point at, std::string_view text, double size, TextAlign align, Color color, bool bold = false);
  /// The same turned to read upwards, centred on `at`.
  void upward_text(Point at, std::string_view text, double size, Color color);
  double text_width(std::string_view text, double size, bool bold = false);

  void push_clip(double x, double y, double width, double height);
  void pop_clip();

 private:
  double run_text(std::string_view text, double size, bool bold, bool draw);

  cairo_t* context_;
};

}  // namespace creepctl
