// A creep curve measured in a laboratory, to be drawn beside computed ones.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"

namespace creepctl {

struct LaboratoryCurve {
  std::string name;                  ///< for the legend
  std::vector<double> age;           ///< since the hold began [s]
  std::vector<double> axial_strain;  ///< since then [-], compression positive
};

/// A csv text with the columns age_s and axial_strain; others are passed over, and lines that begin with #.
/// `name` is for legend and messages. Error: InvalidArgument.
absl::StatusOr<LaboratoryCurve> parse_laboratory_curve(std::string_view text, std::string name);

}  // namespace creepctl
