// A measured grading curve from a csv file, as the points of a job file.
#pragma once

#include <string>
#include <string_view>

#include "core/experiment/diagnostic.h"

namespace creepctl {

/// TOML text of an array of points, `[["0.1 mm", 0.0], ...]`, or what is wrong with the csv.
struct GradingCsv {
  std::string points;
  std::vector<creep::Diagnostic> errors;
};

/// Two columns, separated by comma, semicolon or tab: diameter and mass passing. A header line names the
/// units: `diameter_mm,passing` (also _m, _um; passing_percent). Without a header, each diameter has its unit
/// ("0.1 mm") and passing is a fraction. Empty lines and lines that begin with # are skipped.
GradingCsv read_grading_csv(std::string_view text);

}  // namespace creepctl
