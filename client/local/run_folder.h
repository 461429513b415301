// The job directory as `run` finds and leaves it before the worker starts.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "absl/status/statusor.h"

namespace creepctl {

enum class RunFolderState {
  kNew,         ///< empty or not there
  kUnfinished,  ///< holds the same job, not done
  kFinished,    ///< holds the same job, done
};

/// Looks, changes nothing. Errors: FailedPrecondition (a run of another job file, files that belong to no
/// run, or not a directory), Unavailable (cannot be read).
absl::StatusOr<RunFolderState> look_at_run_folder(const std::filesystem::path& folder,
                                                  std::string_view job_text, const std::string& job_path);

/// Makes the folder and stores the job file in it, durably and whole or not at all. Error: Unavailable.
absl::Status begin_run_folder(const std::filesystem::path& folder, std::string_view job_text);

/// Writes a file durably, whole or not at all. Error: Unavailable.
absl::Status write_by_rename(const std::filesystem::path& path, std::string_view bytes);

/// Whether a worker holds the lease of the folder now.
bool is_worker_at(const std::filesystem::path& folder);

/// The bytes of a file, "" if it cannot be read.
std::string read_text(const std::filesystem::path& path);

/// The last lines of a text.
std::string last_lines(std::string_view text, int count);

}  // namespace creepctl
