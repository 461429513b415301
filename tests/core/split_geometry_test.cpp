#include "core/physics/split_geometry.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <vector>

namespace creep {
namespace {

constexpr double kRounding = 1e-12;

const std::vector<SplitLayout> kLayouts = {SplitLayout::kOctahedral, SplitLayout::kCubic,
                                           SplitLayout::kTetrahedral};

TEST(SplitGeometry, siblings_touch_the_parent_from_inside_and_never_overlap) {
  for (const SplitLayout layout : kLayouts) {
    const auto& siblings = sibling_layout(layout);
    EXPECT_EQ(siblings.size(), 14u);
    for (std::size_t i = 0; i < siblings.size(); ++i) {
      EXPECT_NEAR(siblings[i].centre.norm() + siblings[i].radius, 1.0, kRounding);
      for (std::size_t j = i + 1; j < siblings.size(); ++j) {
        const double distance = (siblings[i].centre - siblings[j].centre).norm();
        EXPECT_GE(distance - siblings[i].radius - siblings[j].radius, -kRounding) << i << " " << j;
      }
    }
  }
}

TEST(SplitGeometry, every_sibling_touches_at_least_three_others) {
  for (const SplitLayout layout : kLayouts) {
    const auto& siblings = sibling_layout(layout);
    // The six small ones of the tetrahedral layout sit on an edge: they touch its two large ends and nothing
    // else.
    for (std::size_t i = 0; i < siblings.size(); ++i) {
      int touching = 0;
      for (std::size_t j = 0; j < siblings.size(); ++j) {
        const double distance = (siblings[i].centre - siblings[j].centre).norm();
        touching += j != i && std::fabs(distance - siblings[i].radius - siblings[j].radius) < kRounding;
      }
      EXPECT_GE(touching, layout == SplitLayout::kTetrahedral && i >= 8 ? 2 : 3) << i;
    }
  }
}

TEST(SplitGeometry, radii_and_kept_volumes_are_those_of_the_model) {
  const auto sizes = [](SplitLayout layout) {
    std::vector<double> radii;
    for (const Sibling& s : sibling_layout(layout)) radii.push_back(s.radius);
    EXPECT_TRUE(std::is_sorted(radii.rbegin(), radii.rend()));  // larger ones first
    return radii;
  };
  constexpr double kDigits = 0.5e-6;  // half a unit of the last printed digit
  const auto octahedral = sizes(SplitLayout::kOctahedral);
  EXPECT_NEAR(octahedral[5], 0.414214, kDigits);
  EXPECT_NEAR(octahedral[6], 0.230093, kDigits);
  const auto cubic = sizes(SplitLayout::kCubic);
  EXPECT_NEAR(cubic[7], 0.366025, kDigits);
  EXPECT_NEAR(cubic[8], 0.267949, kDigits);
  const auto tetrahedral = sizes(SplitLayout::kTetrahedral);
  EXPECT_NEAR(tetrahedral[3], 0.449490, kDigits);
  EXPECT_NEAR(tetrahedral[4], 0.289898, kDigits);
  EXPECT_NEAR(tetrahedral[7], 0.289898, kDigits);
  EXPECT_NEAR(tetrahedral[8], 0.205605, kDigits);
  EXPECT_NEAR(kept_volume_fraction(SplitLayout::kOctahedral), 0.52386, 0.5e-5);
  EXPECT_NEAR(kept_volume_fraction(SplitLayout::kCubic), 0.50773, 0.5e-5);
  EXPECT_NEAR(kept_volume_fraction(SplitLayout::kTetrahedral), 0.512864, 0.5e-6);
  for (const SplitLayout layout : kLayouts) EXPECT_EQ(smallest_sibling_radius(layout), sizes(layout).back());
}

TEST(SplitGeometry, octahedral_and_tetrahedral_siblings_support_the_loaded_pole) {
  const Sibling& top = sibling_layout(SplitLayout::kTetrahedral)[0];
  EXPECT_NEAR(top.centre.z(), 0.550510, 0.5e-6);
  EXPECT_EQ(top.centre.head<2>().norm(), 0.0);
  const auto& octahedral = sibling_layout(SplitLayout::kOctahedral);
  EXPECT_NEAR(octahedral[4].centre.z(), 0.585786, 0.5e-6);
  EXPECT_NEAR(octahedral[5].centre.z(), -0.585786, 0.5e-6);
}

TEST(SplitGeometry, centre_of_mass_of_the_siblings_is_the_parents_for_every_layout) {
  // Otherwise a split would move mass. The tetrahedral layout has no inversion centre but four threefold
  // axes.
  for (const SplitLayout layout : kLayouts) {
    Eigen::Vector3d moment = Eigen::Vector3d::Zero();
    for (const Sibling& s : sibling_layout(layout)) moment += s.radius * s.radius * s.radius * s.centre;
    EXPECT_LT(moment.norm(), kRounding);
  }
}

TEST(SplitGeometry, rotation_is_proper_and_takes_z_to_the_axis_everywhere) {
  const double tiny = 1e-9;
  const std::vector<Eigen::Vector3d> axes = {{0, 0, 1},        {0, 0, -1},    {1, 0, 0},     {0, -1, 0},
                                             {0.6, 0, -0.8},   {tiny, 0, -1}, {0, tiny, -1}, {-tiny, tiny, 1},
                                             {0.6, 0.8, tiny}, {1, 2, 3},     {-3, 1, -2}};
  for (Eigen::Vector3d axis : axes) {
    axis.normalize();
    for (const double turn : {0.0, 0.125, 0.4, 0.999}) {
      const Eigen::Matrix3d rotation = rotation_from_z(axis, turn);
      EXPECT_EQ((rotation.col(2) - axis).norm(), 0.0);
      EXPECT_LT((rotation.transpose() * rotation - Eigen::Matrix3d::Identity()).norm(), 1e-14);
      EXPECT_NEAR(rotation.determinant(), 1.0, 1e-14);
    }
  }
}

TEST(SplitGeometry, azimuth_turns_about_the_axis) {
  const Eigen::Vector3d axis = Eigen::Vector3d(0.2, -0.5, -0.7).normalized();
  const Eigen::Matrix3d turned = rotation_from_z(axis, 0.3);
  const Eigen::Matrix3d expected =
      Eigen::AngleAxisd(0.3 * 2.0 * 3.141592653589793, axis).toRotationMatrix() * rotation_from_z(axis, 0.0);
  EXPECT_LT((turned - expected).norm(), 1e-14);
}

}  // namespace
}  // namespace creep
