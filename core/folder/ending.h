// How an attempt ends: the exit code the outside acts on, and verdict.json, which says the same to a daemon
// that was away.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/output/outcome.h"

namespace creep {

inline constexpr int kDone = 0;           ///< the outcome is there; a creep failure is one
inline constexpr int kUsage = 64;         ///< wrong options
inline constexpr int kBadInput = 65;      ///< job.toml is wrong: never try again
inline constexpr int kLeaseHeld = 69;     ///< another worker computes here: nothing was touched
inline constexpr int kRefused = 70;       ///< a guard, a sample mismatch or a refused resume: never try again
inline constexpr int kOutOfMemory = 71;   ///< counts as a crash
inline constexpr int kIoError = 74;       ///< the last good checkpoint stands; try again when there is room
inline constexpr int kCheckpointed = 75;  ///< run me again

struct Ending {
  int exit_code = kDone;
  std::string outcome;  ///< "completed", "creep_failure", "guard_stop", "checkpointed", "refused",
                        ///< "bad_input", "io_error"
  std::string reason;   ///< one sentence
  std::string advice;   ///< what cures it; may be empty
};

Ending ending_of(const Outcome& outcome);

/// InvalidArgument is bad input; Aborted (sample mismatch) and FailedPrecondition (refused resume) end for
/// good; everything else comes from the file system.
Ending ending_of(const absl::Status& status);

/// Durable.
absl::Status write_verdict(const std::filesystem::path& path, const Ending& ending, std::int64_t attempt);

/// What verdict.json says; nothing if there is none or it cannot be read.
std::optional<Ending> read_verdict(const std::filesystem::path& path);

}  // namespace creep
