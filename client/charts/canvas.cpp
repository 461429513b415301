#include "client/charts/canvas.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace creepctl {
namespace {

constexpr double kScriptSize = 0.72;  // of a raised or lowered part, relative to its text
constexpr double kRaise = 0.36;       // of the text size
constexpr double kLower = 0.18;

}  // namespace

void Canvas::rectangle(double x, double y, double width, double height, Color fill, double opacity) {
  cairo_set_source_rgba(context_, fill.red, fill.green, fill.blue, opacity);
  cairo_rectangle(context_, x, y, width, height);
  cairo_fill(context_);
}

void Canvas::area(const std::vector<Point>& corners, Color fill, double opacity) {
  if (corners.size() < 3) return;
  cairo_set_source_rgba(context_, fill.red, fill.green, fill.blue, opacity);
  for (const Point& corner : corners) cairo_line_to(context_, corner.x, corner.y);
  cairo_close_path(context_);
  cairo_fill(context_);
}

void Canvas::frame(double x, double y, double width, double height, Color stroke, double line_width) {
  cairo_set_source_rgb(context_, stroke.red, stroke.green, stroke.blue);
  cairo_set_line_width(context_, line_width);
  cairo_set_dash(context_, nullptr, 0, 0.0);
  cairo_rectangle(context_, x, y, width, height);
  cairo_stroke(context_);
}

void Canvas::line(const std::vector<Point>& points, Color stroke, double line_width, Dash dash) {
  if (points.size() < 2) return;
  constexpr double kDashes[] = {7.0, 4.0};
  constexpr double kDots[] = {2.0, 3.0};
  cairo_set_source_rgb(context_, stroke.red, stroke.green, stroke.blue);
  cairo_set_line_width(context_, line_width);
  cairo_set_line_join(context_, CAIRO_LINE_JOIN_ROUND);
  cairo_set_dash(context_, dash == Dash::kDotted ? kDots : kDashes, dash == Dash::kSolid ? 0 : 2, 0.0);
  cairo_move_to(context_, points[0].x, points[0].y);
  for (std::size_t i = 1; i < points.size(); ++i) cairo_line_to(context_, points[i].x, points[i].y);
  cairo_stroke(context_);
}

void Canvas::marker(Point at, Marker marker, double radius, Color fill) {
  if (marker == Marker::kNone) return;
  cairo_set_dash(context_, nullptr, 0, 0.0);
  cairo_new_path(context_);
  if (marker == Marker::kCircle) {
    cairo_arc(context_, at.x, at.y, radius, 0.0, 2.0 * std::numbers::pi);
  } else if (marker == Marker::kSquare) {
    cairo_rectangle(context_, at.x - 0.9 * radius, at.y - 0.9 * radius, 1.8 * radius, 1.8 * radius);
  } else {
    const int corners = marker == Marker::kStar ? 10 : 4;
    for (int i = 0; i < corners; ++i) {
      const double reach =
          marker == Marker::kStar ? (i % 2 == 0 ? 1.7 * radius : 0.7 * radius) : 1.25 * radius;
      const double turn = 2.0 * std::numbers::pi * i / corners - 0.5 * std::numbers::pi;
      cairo_line_to(context_, at.x + reach * std::cos(turn), at.y + reach * std::sin(turn));
    }
    cairo_close_path(context_);
  }
  cairo_set_source_rgb(context_, fill.red, fill.green, fill.blue);
  cairo_fill_preserve(context_);
  cairo_set_source_rgb(context_, 1.0, 1.0, 1.0);
  cairo_set_line_width(context_, 0.8);
  cairo_stroke(context_);
}

double Canvas::run_text(std::string_view text, double size, bool bold, bool draw) {
  cairo_select_font_face(context_, "DejaVu Sans", CAIRO_FONT_SLANT_NORMAL,
                         bold ? CAIRO_FONT_WEIGHT_BOLD : CAIRO_FONT_WEIGHT_NORMAL);
  double width = 0.0;
  std::size_t place = 0;
  while (place < text.size()) {
    std::size_t end = text.find_first_of("^_", place);
    while (end != std::string_view::npos && text.substr(end + 1, 1) != "{")
      end = text.find_first_of("^_", end + 1);
    double part_size = size;
    double shift = 0.0;
    std::string part;
    if (end == place) {
      const std::size_t close = std::min(text.find('}', place), text.size());
      part = std::string(text.substr(place + 2, close - place - 2));
      part_size = kScriptSize * size;
      shift = text[place] == '^' ? -kRaise * size : kLower * size;
      place = std::min(close + 1, text.size());
    } else {
      part =
          std::string(text.substr(place, end == std::string_view::npos ? text.size() - place : end - place));
      place += part.size();
    }
    cairo_set_font_size(context_, part_size);
    cairo_text_extents_t extents;
    cairo_text_extents(context_, part.c_str(), &extents);
    if (draw) {
      double x = 0.0;
      double y = 0.0;
      cairo_get_current_point(context_, &x, &y);
      cairo_rel_move_to(context_, 0.0, shift);
      cairo_show_text(context_, part.c_str());
      cairo_move_to(context_, x + extents.x_advance, y);
    }
    width += extents.x_advance;
  }
  return width;
}

double Canvas::text_width(std::string_view text, double size, bool bold) {
  return run_text(text, size, bold, false);
}

void Canvas::text(Point at, std::string_view text, double size, TextAlign align, Color color, bool bold) {
  const double width = align == TextAlign::kLeft ? 0.0 : text_width(text, size, bold);
  cairo_set_source_rgb(context_, color.red, color.green, color.blue);
  cairo_move_to(context_, at.x - (align == TextAlign::kRight ? width : 0.5 * width), at.y);
  run_text(text, size, bold, true);
  cairo_new_path(context_);
}

void Canvas::upward_text(Point at, std::string_view text, double size, Color color) {
  cairo_save(context_);
  cairo_translate(context_, at.x, at.y);
  cairo_rotate(context_, -0.5 * std::numbers::pi);
  this->text({0.0, 0.35 * size}, text, size, TextAlign::kCentre, color);
  cairo_restore(context_);
}

void Canvas::push_clip(double x, double y, double width, double height) {
  cairo_save(context_);
  cairo_rectangle(context_, x, y, width, height);
  cairo_clip(context_);
}

void Canvas::pop_clip() { cairo_restore(context_); }

}  // namespace creepctl
