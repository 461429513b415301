// The values that a sweep goes through, as they are written on the command line. Pure.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/statusor.h"

namespace creepctl {

/// "5" is 1 to 5, "1..5" the same, "1,3,7..9" a list. Error: InvalidArgument, with what was meant to be
/// there; the same seed twice; more than 1000.
absl::StatusOr<std::vector<std::int64_t>> parse_seeds(const std::string& text);

/// "0.2,0.75": shares of the shear strength, above 0 and at most 2. Error: InvalidArgument, also for the same
/// twice.
absl::StatusOr<std::vector<double>> parse_stress_ratios(const std::string& text);

/// A key of the job file with the values it takes in turn.
struct VariedKey {
  std::string key;
  std::vector<std::string> values;  ///< TOML, or text that is taken as a string
};

/// "KEY=A,B,C". A comma inside quotes, brackets or braces belongs to the value. Error: InvalidArgument.
absl::StatusOr<VariedKey> parse_varied_key(const std::string& text);

}  // namespace creepctl
