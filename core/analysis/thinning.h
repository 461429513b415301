// Thinning of a curve for a chart: fewer rows that draw the same line, whatever the zoom.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace creep {

/// How rows fall into buckets by the value of one column.
struct Buckets {
  double width = 0.0;   ///< above 0: of equal width, in the unit of the column
  int per_decade = 60;  ///< else: of equal ratio; all values up to 0 are one bucket
};

struct ThinnedRow {
  std::uint64_t index = 0;
  std::vector<double> values;
};

/// Of each bucket stay its first and its last row and, of each column, the first of the least and the first
/// of the greatest values. A bucket ends where the next row falls into another: which rows stay depends on
/// the rows alone, not on how many follow, nor on the portions in which they come. NaN is neither least nor
/// greatest.
class Thinner {
 public:
  Thinner(Buckets buckets, std::size_t columns);

  /// The next row: its value of the column the buckets are made of, and those of the columns wanted.
  void add(std::uint64_t index, double by, std::span<const double> values);

  /// Rows that stay of the buckets that have ended, in order.
  const std::vector<ThinnedRow>& rows() const { return rows_; }
  /// Index of the first row of the bucket that has not; none before the first row.
  std::uint64_t open_bucket() const { return open_ ? first_.index : 0; }
  /// Takes its rows too, as if it had ended.
  void end_bucket();

 private:
  double bucket_of(double by) const;

  Buckets buckets_;
  bool open_ = false;
  double bucket_ = 0.0;
  ThinnedRow first_, last_;
  std::vector<ThinnedRow> least_, greatest_;  ///< a row for each column; empty values: none yet
  std::vector<ThinnedRow> rows_;
};

}  // namespace creep
