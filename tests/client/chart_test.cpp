#include "client/charts/chart.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace creepctl {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

std::vector<std::string> labels(const std::vector<Tick>& ticks) {
  std::vector<std::string> out;
  for (const Tick& tick : ticks) {
    if (!tick.label.empty()) out.push_back(tick.label);
  }
  return out;
}

Chart one_series(std::vector<double> x, std::vector<double> y, Scale x_scale, Scale y_scale) {
  Chart chart;
  chart.title = "title";
  chart.x = {"x (s)", x_scale, {}, {}, false};
  chart.y = {"y (%)", y_scale, {}, {}, false};
  Series series{"series", std::move(x), std::move(y)};
  series.marker = Marker::kCircle;
  chart.series = {series};
  return chart;
}

void expect_everything_inside(const Layout& placed) {
  const Box frame{placed.plot.x - 0.5, placed.plot.y - 0.5, placed.plot.width + 1.0,
                  placed.plot.height + 1.0};
  for (const auto& points : placed.points) {
    for (const PlacedPoint& point : points)
      EXPECT_TRUE(frame.contains(point.at)) << point.at.x << ", " << point.at.y;
  }
}

TEST(LinearAxis, HasRoundTicksWithAsManyDecimalsAsTheirStep) {
  EXPECT_EQ(labels(axis_ticks(Scale::kLinear, {0.0, 1.2}, 8)),
            (std::vector<std::string>{"0", "0.2", "0.4", "0.6", "0.8", "1.0", "1.2"}));
  EXPECT_EQ(labels(axis_ticks(Scale::kLinear, {0.56, 0.66}, 8)),
            (std::vector<std::string>{"0.56", "0.58", "0.60", "0.62", "0.64", "0.66"}));
  EXPECT_EQ(labels(axis_ticks(Scale::kLinear, {-10.0, 10.0}, 4)),
            (std::vector<std::string>{"−10", "−5", "0", "5", "10"}));
}

TEST(LinearAxis, MinorTicksDivideTheMajorOnes) {
  const auto ticks = axis_ticks(Scale::kLinear, {0.0, 1.0}, 5);
  EXPECT_EQ(std::count_if(ticks.begin(), ticks.end(), [](const Tick& t) { return t.major; }), 6);
  for (std::size_t i = 1; i < ticks.size(); ++i) EXPECT_GT(ticks[i].value, ticks[i - 1].value);
  EXPECT_GE(ticks.size(), 21u);
}

TEST(LinearAxis, WritesVerySmallAndVeryLargeNumbersWithAPower) {
  EXPECT_EQ(labels(axis_ticks(Scale::kLinear, {0.0, 4e-7}, 4)).at(1), "1×10^{−7}");
  EXPECT_EQ(labels(axis_ticks(Scale::kLinear, {0.0, 3e8}, 3)).at(3), "3×10^{8}");
  EXPECT_EQ(tick_label(1.25e7, 5e5), "1.25×10^{7}");
}

TEST(LogAxis, LabelsDecadesAsPowersAndShortOnesPlainly) {
  EXPECT_EQ(labels(axis_ticks(Scale::kLog, {1e-3, 1e6}, 10)).front(), "10^{−3}");
  EXPECT_EQ(labels(axis_ticks(Scale::kLog, {1e-3, 1e6}, 10)).size(), 10u);
  EXPECT_EQ(labels(axis_ticks(Scale::kLog, {0.01, 1.0}, 10)), (std::vector<std::string>{"0.01", "0.1", "1"}));
}

TEST(LogAxis, HasEightMinorTicksADecadeAtTheirPlaces) {
  const auto ticks = axis_ticks(Scale::kLog, {1.0, 100.0}, 10);
  ASSERT_EQ(ticks.size(), 19u);
  EXPECT_DOUBLE_EQ(ticks[1].value, 2.0);
  EXPECT_DOUBLE_EQ(ticks[17].value, 90.0);
  EXPECT_FALSE(ticks[1].major);
  EXPECT_TRUE(ticks[9].major);
}

TEST(LogAxis, LabelsMultiplesWhenThereAreFewDecadesAndSkipsDecadesWhenThereAreMany) {
  EXPECT_EQ(labels(axis_ticks(Scale::kLog, {0.1, 1.0}, 10)),
            (std::vector<std::string>{"0.1", "0.2", "0.5", "1"}));
  EXPECT_LE(labels(axis_ticks(Scale::kLog, {1e-30, 1e30}, 10)).size(), 11u);
  for (const AxisRange narrow : {AxisRange{0.31, 0.39}, AxisRange{2.0, 5.0}, AxisRange{7.0, 12.0}}) {
    EXPECT_GE(labels(axis_ticks(Scale::kLog, narrow, 10)).size(), 2u) << narrow.low;
  }
}

TEST(AxisRangeChoice, GivesConstantDataRoomAndNeverAnEmptyRange) {
  for (const double value : {0.0, 0.65, -3.0, 1e-12, 1e12}) {
    const AxisRange range = axis_range(Scale::kLinear, {value, value});
    EXPECT_LT(range.low, value);
    EXPECT_GT(range.high, value);
    EXPECT_GE(labels(axis_ticks(Scale::kLinear, range, 8)).size(), 2u) << value;
  }
  const AxisRange range = axis_range(Scale::kLog, {21.7, 21.7});
  EXPECT_LT(range.low, 21.7);
  EXPECT_GT(range.high, 21.7);
}

TEST(AxisRangeChoice, LeavesOutWhatTheAxisCannotHold) {
  const auto range = data_range(Scale::kLog, {kNan, -1.0, 0.0, 2.0, 30.0, INFINITY});
  ASSERT_TRUE(range);
  EXPECT_EQ(range->low, 2.0);
  EXPECT_EQ(range->high, 30.0);
  EXPECT_FALSE(data_range(Scale::kLog, {0.0, -1.0}));
  EXPECT_FALSE(data_range(Scale::kLinear, {}));
}

TEST(AxisRangeChoice, BeginsAtZeroWhenTheDataComeNearIt) {
  EXPECT_EQ(axis_range(Scale::kLinear, {0.02, 1.1}).low, 0.0);
  EXPECT_GT(axis_range(Scale::kLinear, {0.56, 0.65}).low, 0.5);
  EXPECT_GE(axis_range(Scale::kLinear, {0.02, 1.1}).high, 1.1);
}

TEST(AxisPosition, IsLinearInTheValueOrItsLogarithm) {
  EXPECT_DOUBLE_EQ(axis_position(Scale::kLinear, {10.0, 20.0}, 15.0), 0.5);
  EXPECT_NEAR(axis_position(Scale::kLog, {1e-2, 1e2}, 1.0), 0.5, 1e-15);
}

TEST(ChartLayout, DropsValuesThatALogAxisCannotHoldAndKeepsTheirIndices) {
  const Layout placed = layout(
      one_series({0.0, 1.0, 10.0, 100.0, 1000.0}, {1.0, 2.0, kNan, 4.0, 5.0}, Scale::kLog, Scale::kLinear));
  ASSERT_EQ(placed.points[0].size(), 3u);
  EXPECT_EQ(placed.points[0][0].index, 1u);
  EXPECT_EQ(placed.points[0][1].index, 3u);
  EXPECT_EQ(placed.paths[0].size(), 3u);
  expect_everything_inside(placed);
}

TEST(ChartLayout, PlacesLargerValuesFurtherRightAndHigherUp) {
  const Layout placed = layout(one_series({1.0, 10.0, 100.0}, {1.0, 2.0, 3.0}, Scale::kLog, Scale::kLinear));
  EXPECT_NEAR(placed.points[0][1].at.x - placed.points[0][0].at.x,
              placed.points[0][2].at.x - placed.points[0][1].at.x, 1e-9);
  EXPECT_LT(placed.points[0][2].at.y, placed.points[0][0].at.y);
}

TEST(ChartLayout, DrawsNothingAndOnePointAndConstantDataToo) {
  const Chart charts[] = {one_series({}, {}, Scale::kLog, Scale::kLog),
                          one_series({3.0}, {0.5}, Scale::kLog, Scale::kLinear),
                          one_series({1.0, 2.0, 3.0}, {0.6, 0.6, 0.6}, Scale::kLinear, Scale::kLinear),
                          one_series({kNan, -1.0}, {1.0, 2.0}, Scale::kLog, Scale::kLog), Chart{}};
  for (const Chart& chart : charts) {
    expect_everything_inside(layout(chart));
    EXPECT_NE(draw_svg(chart, "").find("</svg>"), std::string::npos);
    EXPECT_TRUE(draw_png(chart).ok());
  }
}

TEST(ChartLayout, StairsKeepTheirValueUntilTheNextPoint) {
  Chart chart = one_series({1.0, 2.0}, {1.0, 5.0}, Scale::kLinear, Scale::kLinear);
  chart.series[0].shape = Shape::kStairs;
  const Layout placed = layout(chart);
  ASSERT_EQ(placed.paths[0].size(), 3u);
  EXPECT_EQ(placed.paths[0][1].y, placed.paths[0][0].y);
  EXPECT_EQ(placed.paths[0][1].x, placed.paths[0][2].x);
}

TEST(ChartLayout, PutsTheLegendWhereItHidesNoData) {
  for (const bool rising : {true, false}) {
    std::vector<double> x;
    std::vector<double> y;
    for (int i = 0; i <= 50; ++i) {
      x.push_back(i);
      y.push_back(rising ? i : 50 - i);
    }
    const Layout placed = layout(one_series(x, y, Scale::kLinear, Scale::kLinear));
    const Box box = place_box(placed, 200.0, 90.0);
    for (const PlacedPoint& point : placed.points[0]) EXPECT_FALSE(box.contains(point.at));
    EXPECT_TRUE(placed.plot.contains({box.x, box.y}));
    EXPECT_TRUE(placed.plot.contains({box.x + box.width, box.y + box.height}));
  }
}

TEST(ChartPictures, AreWholeFilesAndIdsCarryTheirPrefix) {
  const Chart chart = one_series({1.0, 10.0}, {1.0, 2.0}, Scale::kLog, Scale::kLinear);
  const std::string svg = draw_svg(chart, "p3-");
  EXPECT_EQ(svg.find(" id=\"glyph"), std::string::npos);
  EXPECT_NE(svg.find(" id=\"p3-glyph"), std::string::npos);
  EXPECT_EQ(svg.find("href=\"#glyph"), std::string::npos);
  const auto png = draw_png(chart);
  ASSERT_TRUE(png.ok());
  EXPECT_EQ(png->substr(1, 3), "PNG");
}

}  // namespace
}  // namespace creepctl
