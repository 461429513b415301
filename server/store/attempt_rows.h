// Attempts as rows of the table `attempt` (schema_2.sql).
#pragma once

#include <cstdint>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "server/rules/attempt.h"
#include "server/store/database.h"

namespace creepd {

/// A new row, or the same attempt as it is now.
absl::Status put_attempt(Database& database, std::int64_t job, const Attempt& attempt);

/// Those of a job from `first` on, by number, at most `limit`.
absl::StatusOr<std::vector<Attempt>> read_attempts(Database& database, std::int64_t job, std::int64_t first,
                                                   int limit);

}  // namespace creepd
