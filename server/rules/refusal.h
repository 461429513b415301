// Errors as the API promises them: a code, a reason in UPPER_SNAKE, facts, and all violations at once,
// carried by an absl::Status.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "absl/status/status.h"

namespace creepd {

struct Violation {
  std::string field;
  std::string description;
  int line = 0;  ///< of the job file, from 1; 0 = not a place in it
  int column = 0;
};

struct Refusal {
  std::string reason;
  std::vector<std::pair<std::string, std::string>> facts;
  std::vector<Violation> violations;
  std::optional<int> retry_seconds;
  std::size_t left_out = 0;  ///< violations beyond these
};

/// A status with the reason and what else is known.
absl::Status refuse(absl::StatusCode code, std::string_view message, const Refusal& refusal);

/// NotFound JOB_NOT_FOUND.
absl::Status job_not_found(std::string_view id);

/// InvalidArgument BAD_REQUEST with the violations, at least one.
absl::Status bad_request(std::vector<Violation> violations);

/// What a status carries; an empty reason if it was not made by refuse().
Refusal refusal_of(const absl::Status& status);

}  // namespace creepd
