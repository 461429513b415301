// What the daemon asks of a job file before it takes it, and what the job will need.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "core/experiment/experiment.h"

namespace creepd {

inline constexpr std::size_t kMostSpecBytes = 1 << 20;
inline constexpr std::int64_t kMostParticles = 2'000'000;

struct CheckedSpec {
  std::string name;
  std::string experiment_hash;
  std::string specimen_hash;
  std::optional<creep::Start> start;  ///< the job starts from another's checkpoint
  std::vector<std::string> warnings;  ///< "LINE:COLUMN: message"
  std::uint64_t memory_estimate = 0;  ///< of the worker, fragments included [bytes]
};

/// Error: InvalidArgument INVALID_SPEC with all violations, each at "spec:LINE:COLUMN". Files are refused:
/// the daemon opens nothing that a client names.
absl::StatusOr<CheckedSpec> check_spec(std::string_view text);

}  // namespace creepd
