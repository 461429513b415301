// Changes to the text of a job file before it is read: keys set anew, sections taken over from another job.
// Comments and layout are lost.
#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "absl/status/statusor.h"

namespace creep {

/// KEY and VALUE: "numerics.minimum_cycles", "program.1.duration" (stages count from 0), "program". The value
/// is TOML; what is not, like 2 d, is taken as a string.
using Override = std::pair<std::string, std::string>;

/// The text with each key set in turn; what is missing on the way is made. Error: InvalidArgument, with the
/// key, or the place in the text.
absl::StatusOr<std::string> with_overrides(std::string_view text, const std::vector<Override>& overrides);

/// The text with the sections [specimen], [material] and [numerics] of `source` where it has none. Error:
/// InvalidArgument, if one is no TOML.
absl::StatusOr<std::string> with_sections_of(std::string_view text, std::string_view source);

}  // namespace creep
