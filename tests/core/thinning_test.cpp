// Thinning: what a chart shows of a curve is there, in order, and does not depend on how the curve came.
#include "core/analysis/thinning.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <random>

namespace creep {
namespace {

struct Curve {
  std::vector<double> time;
  std::vector<double> strain;
  std::vector<double> stress;

  std::vector<double> row(std::size_t i) const { return {strain[i], stress[i]}; }
};

/// Strain that grows and a stress that ripples, with a spike here and there.
Curve rippled(std::size_t count) {
  std::mt19937 bits(7);
  std::uniform_real_distribution<double> share(-1.0, 1.0);
  Curve curve;
  for (std::size_t i = 0; i < count; ++i) {
    const double part = static_cast<double>(i) / static_cast<double>(count);
    curve.time.push_back(i < 50 ? 0.0 : std::pow(10.0, -4.0 + 9.0 * part));
    curve.strain.push_back(0.01 * std::log1p(curve.time.back()) + 1e-6 * share(bits));
    curve.stress.push_back(15e6 * (1.0 + 0.01 * share(bits)) + (i % 997 == 0 ? 5e6 : 0.0));
  }
  return curve;
}

std::vector<ThinnedRow> thinned(const Curve& curve, Buckets buckets, std::size_t from, std::size_t to) {
  Thinner thinner(buckets, 2);
  for (std::size_t i = from; i < to; ++i) thinner.add(i, curve.time[i], curve.row(i));
  thinner.end_bucket();
  return thinner.rows();
}

TEST(Thinning, KeepsFirstLeastGreatestAndLastOfEveryBucket) {
  const Curve curve = rippled(20'000);
  const auto rows = thinned(curve, {.per_decade = 20}, 0, curve.time.size());
  EXPECT_LT(rows.size(), 9u * 20u * 6u + 6u);
  std::map<std::uint64_t, bool> kept;
  for (const ThinnedRow& row : rows) kept[row.index] = true;
  const auto bucket = [&](std::size_t i) {
    return curve.time[i] > 0.0 ? std::floor(20.0 * std::log10(curve.time[i])) : -1e9;
  };
  std::size_t begin = 0;
  for (std::size_t end = 1; end <= curve.time.size(); ++end) {
    if (end < curve.time.size() && bucket(end) == bucket(begin)) continue;
    EXPECT_TRUE(kept[begin]) << begin;
    EXPECT_TRUE(kept[end - 1]) << end - 1;
    for (const auto* column : {&curve.strain, &curve.stress}) {
      const auto first = column->begin() + static_cast<std::ptrdiff_t>(begin);
      const auto last = column->begin() + static_cast<std::ptrdiff_t>(end);
      EXPECT_TRUE(kept[static_cast<std::uint64_t>(std::min_element(first, last) - column->begin())]);
      EXPECT_TRUE(kept[static_cast<std::uint64_t>(std::max_element(first, last) - column->begin())]);
    }
    begin = end;
  }
}

TEST(Thinning, RowsStayInOrderWithTheirValues) {
  const Curve curve = rippled(5'000);
  const auto rows = thinned(curve, {}, 0, curve.time.size());
  for (std::size_t i = 0; i < rows.size(); ++i) {
    EXPECT_TRUE(i == 0 || rows[i - 1].index < rows[i].index);
    EXPECT_EQ(rows[i].values, curve.row(rows[i].index));
  }
}

TEST(Thinning, ACurveReadInPortionsIsTheSame) {
  const Curve curve = rippled(1'000);
  for (const Buckets buckets : {Buckets{.per_decade = 30}, Buckets{.width = 1e3}}) {
    const auto whole = thinned(curve, buckets, 0, curve.time.size());
    for (const std::size_t portion : {std::size_t{1}, std::size_t{7}, std::size_t{640}}) {
      std::vector<ThinnedRow> rows;
      std::size_t from = 0;
      for (std::size_t to = portion; from < curve.time.size();
           to = std::min(to + portion, curve.time.size())) {
        // As a reader goes on: the open bucket is told as it is and read again.
        Thinner thinner(buckets, 2);
        for (std::size_t i = from; i < to; ++i) thinner.add(i, curve.time[i], curve.row(i));
        const std::size_t next = thinner.open_bucket();
        thinner.end_bucket();
        std::erase_if(rows, [&](const ThinnedRow& row) { return row.index >= from; });
        rows.insert(rows.end(), thinner.rows().begin(), thinner.rows().end());
        if (to == curve.time.size()) break;
        from = next;
      }
      ASSERT_EQ(rows.size(), whole.size()) << portion;
      for (std::size_t i = 0; i < rows.size(); ++i) EXPECT_EQ(rows[i].index, whole[i].index);
    }
  }
}

TEST(Thinning, NoNumberHidesAnExtreme) {
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  Thinner thinner({.width = 10.0}, 1);
  const double values[] = {kNaN, 2.0, kNaN, 1.0, 3.0, kNaN};
  for (std::size_t i = 0; i < std::size(values); ++i) thinner.add(i, 1.0, std::span(&values[i], 1));
  thinner.end_bucket();
  std::vector<std::uint64_t> kept;
  for (const ThinnedRow& row : thinner.rows()) kept.push_back(row.index);
  EXPECT_EQ(kept, (std::vector<std::uint64_t>{0, 3, 4, 5}));
}

}  // namespace
}  // namespace creep
