// [start] of a job file for `run`: the folder of another run, one of whose checkpoints this one starts from.
#pragma once

#include <filesystem>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "client/job_file/job_file.h"

namespace creepctl {

/// Completes the text and experiment of a job file with [start] from the folder it names (relative to the
/// file) and returns the checkpoint. Error: InvalidArgument, in words.
absl::StatusOr<std::string> take_start(JobFile& job);

/// Puts the checkpoint where a worker looks for it; durable. Error: of the file system.
absl::Status write_start(const std::filesystem::path& run_folder, const std::string& checkpoint);

}  // namespace creepctl
