#include "core/analysis/number_table.h"

#include <algorithm>
#include <charconv>
#include <limits>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"

namespace creep {
namespace {

std::vector<std::string_view> split(std::string_view line) {
  std::vector<std::string_view> cells;
  for (std::size_t begin = 0;;) {
    const std::size_t comma = line.find(',', begin);
    cells.push_back(line.substr(begin, comma == std::string_view::npos ? comma : comma - begin));
    if (comma == std::string_view::npos) return cells;
    begin = comma + 1;
  }
}

std::string_view without_return(std::string_view line) {
  return !line.empty() && line.back() == '\r' ? line.substr(0, line.size() - 1) : line;
}

}  // namespace

absl::StatusOr<NumberTable> NumberTable::parse(std::string_view text, std::string_view name) {
  NumberTable table;
  std::size_t line_number = 0;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = text.find('\n', begin);
    if (end == std::string_view::npos) break;
    const std::string_view line = without_return(text.substr(begin, end - begin));
    begin = end + 1;
    ++line_number;
    if (line.empty()) continue;
    const std::vector<std::string_view> cells = split(line);
    if (table.names_.empty()) {
      for (const std::string_view cell : cells) table.names_.emplace_back(cell);
      table.columns_.resize(cells.size());
      continue;
    }
    const std::string place = absl::StrCat(std::string(name), ":", line_number, ": ");
    if (cells.size() != table.names_.size()) {
      return absl::InvalidArgumentError(
          absl::StrCat(place, cells.size(), " values under a header of ", table.names_.size()));
    }
    for (std::size_t i = 0; i < cells.size(); ++i) {
      double value = 0.0;
      const char* cell_end = cells[i].data() + cells[i].size();
      const auto [stopped, problem] = std::from_chars(cells[i].data(), cell_end, value);
      if (problem != std::errc() || stopped != cell_end) {
        return absl::InvalidArgumentError(absl::StrCat(place, "'", std::string(cells[i]), "' is no number"));
      }
      table.columns_[i].push_back(value);
    }
  }
  return table;
}

bool NumberTable::has(std::string_view column) const {
  return std::find(names_.begin(), names_.end(), column) != names_.end();
}

const std::vector<double>& NumberTable::column(std::string_view name) const {
  static const std::vector<double> kNone;
  const auto found = std::find(names_.begin(), names_.end(), name);
  return found == names_.end() ? kNone : columns_[static_cast<std::size_t>(found - names_.begin())];
}

double NumberTable::at(std::size_t row, std::string_view column_name) const {
  const std::vector<double>& values = column(column_name);
  return row < values.size() ? values[row] : std::numeric_limits<double>::quiet_NaN();
}

}  // namespace creep
