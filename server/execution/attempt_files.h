// What an attempt leaves in its job folder while it runs and when it ends, as the supervisor reads it.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "absl/status/statusor.h"
#include "server/folders/sample_index.h"
#include "server/rules/attempt_ending.h"
#include "server/store/job_store.h"

namespace creepd {

/// verdict.json of this attempt, if it is there.
std::optional<creep::Ending> verdict_of(const std::filesystem::path& folder, std::int64_t attempt);

/// What the folder says about an attempt that is over.
AttemptEnd end_in_folder(const std::filesystem::path& folder, std::int64_t attempt);

/// Samples and progress so far. Errors: DataLoss, or of the file system.
absl::StatusOr<JobStore::Telling> progress_in_folder(const std::string& job,
                                                     const std::filesystem::path& folder,
                                                     SampleIndex& samples);

/// Changes whenever the worker writes its progress.
std::int64_t progress_mark(const std::filesystem::path& folder);

/// Whether the file system has room for an attempt. Its folder need not be there: a power cut may have taken
/// it, and the attempt makes it anew.
bool has_room_for_attempt(const std::filesystem::path& folder);

}  // namespace creepd
