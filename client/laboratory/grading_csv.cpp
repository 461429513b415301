#include "client/laboratory/grading_csv.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <optional>

#include "core/experiment/units.h"
#include "core/experiment/wording.h"

namespace creepctl {
namespace {

std::string_view trimmed(std::string_view text) {
  const auto blank = [](char letter) {
    return letter == ' ' || letter == '\t' || letter == '\r' || letter == '"';
  };
  while (!text.empty() && blank(text.front())) text.remove_prefix(1);
  while (!text.empty() && blank(text.back())) text.remove_suffix(1);
  return text;
}

struct Columns {
  std::string unit;      ///< appended to each diameter; "" = the cells have their own
  double percent = 1.0;  ///< divides passing
};

std::optional<Columns> read_header(std::string_view diameter, std::string_view passing) {
  Columns columns;
  for (const std::string_view unit : {"m", "mm", "um"}) {
    if (diameter == "diameter_" + std::string(unit)) columns.unit = std::string(1, ' ').append(unit);
  }
  if (passing == "passing_percent") columns.percent = 100.0;
  const bool good = (!columns.unit.empty() || diameter == "diameter") &&
                    (passing == "passing" || passing == "passing_percent");
  return good ? std::optional(columns) : std::nullopt;
}

std::optional<double> read_fraction(std::string_view cell, double divisor) {
  double value = 0.0;
  const auto [stop, error] = std::from_chars(cell.data(), cell.data() + cell.size(), value);
  if (error != std::errc() || stop != cell.data() + cell.size() || !std::isfinite(value)) return std::nullopt;
  return value / divisor;
}

/// The row as a TOML point, or what is wrong with it.
struct Row {
  std::string point;
  std::string error;
};

Row read_row(std::string_view diameter, std::string_view passing, const Columns& columns) {
  const std::string quantity = std::string(diameter) + columns.unit;
  const auto length = creep::parse_quantity(quantity, creep::Dimension::kLength);
  if (!length.ok()) return {"", "diameter " + std::string(length.status().message())};
  const auto fraction = read_fraction(passing, columns.percent);
  if (!fraction || *fraction < 0.0 || *fraction > 1.0) {
    const std::string range = columns.percent > 1.0 ? "0 to 100" : "0 to 1";
    return {"", "mass passing " + creep::quoted(passing) + " is not a number from " + range};
  }
  // In metres and in the fewest digits that read back as the same double.
  return {"[\"" + creep::shortest(*length) + " m\", " + creep::shortest(*fraction) +
              (*fraction == std::floor(*fraction) ? ".0]" : "]"),
          ""};
}

}  // namespace

GradingCsv read_grading_csv(std::string_view text) {
  GradingCsv result;
  Columns columns;
  bool first = true;
  int line_number = 0;
  while (!text.empty()) {
    const std::size_t length = std::min(text.find('\n'), text.size());
    const std::string_view line = trimmed(text.substr(0, length));
    text.remove_prefix(std::min(length + 1, text.size()));
    ++line_number;
    if (line.empty() || line.front() == '#') continue;
    const std::size_t separator = line.find_first_of(",;\t");
    if (separator == std::string_view::npos) {
      result.errors.push_back({line_number, 1, "two columns are wanted: diameter, mass fraction passing"});
      if (result.errors.size() > 20) return result;  // this is no csv
      continue;
    }
    const std::string_view diameter = trimmed(line.substr(0, separator));
    const std::string_view passing = trimmed(line.substr(separator + 1));
    const auto header = first ? read_header(diameter, passing) : std::nullopt;
    first = false;
    if (header) {
      columns = *header;
      continue;
    }
    const Row row = read_row(diameter, passing, columns);
    if (!row.error.empty()) result.errors.push_back({line_number, 1, row.error});
    if (result.errors.size() > 20) return result;
    result.points += (result.points.empty() ? "" : ", ") + row.point;
  }
  if (result.points.empty() && result.errors.empty()) {
    result.errors.push_back({1, 1, "no grading point in this file"});
  }
  result.points = "[" + result.points + "]";
  return result;
}

}  // namespace creepctl
