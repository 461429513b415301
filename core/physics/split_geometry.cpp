#include "core/physics/split_geometry.h"

#include <algorithm>
#include <cmath>

#include "core/arithmetic/check.h"
#include "core/arithmetic/elementary.h"

namespace creep {
namespace {

using Layout = std::array<Sibling, kSiblingCount>;

// Every sibling touches the parent from inside, so a sibling of radius r lies at distance 1 - r.

/// Radius of a sphere that touches the parent and spheres of radius q whose directions make an angle with its
/// own: (1-r)^2 - 2 (1-r)(1-q) cos + (1-q)^2 = (r + q)^2 solved for r.
double tangent_radius(double q, double cosine) {
  const double p = 1.0 - q;
  return (1.0 + p * p - q * q - 2.0 * p * cosine) / (2.0 + 2.0 * q - 2.0 * p * cosine);
}

Sibling sibling(double radius, double x, double y, double z) {
  const double factor = (1.0 - radius) / std::sqrt(x * x + y * y + z * z);
  return {Eigen::Vector3d(factor * x, factor * y, factor * z), radius};
}

/// 6 siblings on the axes from `at` on; returns the index after the last.
std::size_t put_on_axes(Layout& layout, std::size_t at, double radius) {
  for (const double sign : {1.0, -1.0}) layout[at++] = sibling(radius, sign, 0.0, 0.0);
  for (const double sign : {1.0, -1.0}) layout[at++] = sibling(radius, 0.0, sign, 0.0);
  for (const double sign : {1.0, -1.0}) layout[at++] = sibling(radius, 0.0, 0.0, sign);
  return at;
}

/// 8 siblings along <111>, x changing fastest.
std::size_t put_on_diagonals(Layout& layout, std::size_t at, double radius) {
  for (const double z : {1.0, -1.0}) {
    for (const double y : {1.0, -1.0}) {
      for (const double x : {1.0, -1.0}) layout[at++] = sibling(radius, x, y, z);
    }
  }
  return at;
}

Layout make_octahedral() {
  Layout layout;
  const double large = std::sqrt(2.0) - 1.0;  // neighbours touch: sqrt2 (1 - r) = 2 r
  const std::size_t next = put_on_axes(layout, 0, large);
  put_on_diagonals(layout, next, tangent_radius(large, 1.0 / std::sqrt(3.0)));
  return layout;
}

Layout make_cubic() {
  Layout layout;
  const double large = 1.0 / (1.0 + std::sqrt(3.0));  // neighbours touch: (1 - r)/sqrt3 = r
  const std::size_t next = put_on_diagonals(layout, 0, large);
  put_on_axes(layout, next, tangent_radius(large, 1.0 / std::sqrt(3.0)));
  return layout;
}

Layout make_tetrahedral() {
  Layout layout;
  const double large = std::sqrt(6.0) - 2.0;  // neighbours touch: sqrt(8/3) (1 - r) = 2 r
  const double opposite = tangent_radius(large, 1.0 / 3.0);
  const double edge = tangent_radius(large, 1.0 / std::sqrt(3.0));
  const double third = 1.0 / 3.0;
  const std::array<std::array<double, 3>, 4> corners = {
      {{0.0, 0.0, 1.0},
       {2.0 * std::sqrt(2.0) / 3.0, 0.0, -third},
       {-std::sqrt(2.0) / 3.0, std::sqrt(2.0 / 3.0), -third},
       {-std::sqrt(2.0) / 3.0, -std::sqrt(2.0 / 3.0), -third}}};
  std::size_t at = 0;
  for (const auto& v : corners) layout[at++] = sibling(large, v[0], v[1], v[2]);
  for (const auto& v : corners) layout[at++] = sibling(opposite, -v[0], -v[1], -v[2]);
  for (std::size_t i = 0; i < corners.size(); ++i) {
    for (std::size_t j = i + 1; j < corners.size(); ++j) {
      const auto& v = corners[i];
      const auto& w = corners[j];
      layout[at++] = sibling(edge, v[0] + w[0], v[1] + w[1], v[2] + w[2]);
    }
  }
  return layout;
}

}  // namespace

const std::array<Sibling, kSiblingCount>& sibling_layout(SplitLayout layout) {
  static const Layout kOctahedral = make_octahedral();
  static const Layout kCubic = make_cubic();
  static const Layout kTetrahedral = make_tetrahedral();
  switch (layout) {
    case SplitLayout::kOctahedral:
      return kOctahedral;
    case SplitLayout::kCubic:
      return kCubic;
    case SplitLayout::kTetrahedral:
      return kTetrahedral;
  }
  CREEP_CHECK(false, "unknown split layout");
}

double kept_volume_fraction(SplitLayout layout) {
  double volume = 0.0;
  for (const Sibling& s : sibling_layout(layout)) volume += s.radius * s.radius * s.radius;
  return volume;
}

double smallest_sibling_radius(SplitLayout layout) {
  double radius = 1.0;
  for (const Sibling& s : sibling_layout(layout)) radius = std::min(radius, s.radius);
  return radius;
}

Eigen::Matrix3d rotation_from_z(const Eigen::Vector3d& axis, double azimuth_turn) {
  // Orthonormal basis without cancellation for any axis (Duff et al. 2017, J. Comput. Graph. Tech. 6(1)).
  const double x = axis.x(), y = axis.y(), z = axis.z();
  const double sign = std::copysign(1.0, z);
  const double a = -1.0 / (sign + z);
  const double b = x * y * a;
  const std::array<double, 3> first = {1.0 + sign * x * x * a, sign * b, -sign * x};
  const std::array<double, 3> second = {b, sign + y * y * a, -y};
  const auto [sine, cosine] = elementary::sin_cos_turn(azimuth_turn);
  Eigen::Matrix3d rotation;
  for (int row = 0; row < 3; ++row) {
    const auto i = static_cast<std::size_t>(row);
    rotation(row, 0) = cosine * first[i] + sine * second[i];
    rotation(row, 1) = cosine * second[i] - sine * first[i];
    rotation(row, 2) = axis(row);
  }
  return rotation;
}

}  // namespace creep
