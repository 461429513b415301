// The tables of a job directory, as text.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"

namespace creep {

/// A csv table of numbers, read by column name: further columns are kept, missing ones are empty.
class NumberTable {
 public:
  NumberTable() = default;

  /// `name` is for messages. A last line without its newline is still being written and is left out.
  /// Error: InvalidArgument for a line of another length than the header or a cell that is no number.
  static absl::StatusOr<NumberTable> parse(std::string_view text, std::string_view name);

  std::size_t rows() const { return columns_.empty() ? 0 : columns_.front().size(); }
  bool has(std::string_view column) const;

  /// The values of a column; empty if there is none of that name.
  const std::vector<double>& column(std::string_view name) const;

  /// One value; NaN if there is no such column or row, which charts and tables leave out.
  double at(std::size_t row, std::string_view column) const;

 private:
  std::vector<std::string> names_;
  std::vector<std::vector<double>> columns_;
};

}  // namespace creep
