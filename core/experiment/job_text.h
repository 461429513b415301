// Changes to the text of a job file before it is read: keys set anew, sections taken over from another job.
// Comments and layout are lost.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "absl/status/statusor.h"

namespace creep {

/// KEY and VALUE: "numerics.minimum_cycles", "program.1.duration" (stages count from 0), "program". The value
/// is TOML; what is not, like 2 d, is taken as a string.
using Override = std::pair<std::string, std::string>;

/// "KEY=VALUE" as it is written behind --set; none without a key or a '='.
std::optional<Override> parse_override(std::string_view text);

struct OverrideFault {
  std::string key;
  std::string message;
};

/// The text with each key set in turn; what is missing on the way is made. Error: InvalidArgument, with the
/// key, or the place in the text. `faults` gets every override that cannot be set.
absl::StatusOr<std::string> with_overrides(std::string_view text, const std::vector<Override>& overrides,
                                           std::vector<OverrideFault>* faults = nullptr);

/// The text without these keys; one that is not there is passed over. Error: InvalidArgument, with the place
/// in the text.
absl::StatusOr<std::string> without_keys(std::string_view text, const std::vector<std::string>& keys);

/// The text with `count` stages of its program from the one at `first` on (from 0) and no others. Error:
/// InvalidArgument, if the text is no TOML or has not so many.
absl::StatusOr<std::string> with_stages(std::string_view text, std::size_t first, std::size_t count);

/// The string at a key like "program.1.until.q_max"; none if there is none.
std::optional<std::string> string_at(std::string_view text, const std::string& key);

/// The text with the sections [specimen], [material] and [numerics] of `source` where it has none. Error:
/// InvalidArgument, if one is no TOML.
absl::StatusOr<std::string> with_sections_of(std::string_view text, std::string_view source);

}  // namespace creep
