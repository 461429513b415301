#include "server/execution/upkeep.h"

#include <string>
#include <system_error>
#include <vector>

#include "absl/strings/str_cat.h"
#include "core/folder/durable_file.h"
#include "core/folder/job_directory.h"
#include "server/execution/attempt_files.h"
#include "server/host/daemon_log.h"
#include "server/host/wall_clock.h"

namespace creepd {
namespace {

namespace fs = std::filesystem;

constexpr std::chrono::seconds kStorageLook{2};
constexpr std::chrono::hours kRequestLook{1};
constexpr Moment kRequestsKept = std::int64_t{30} * 86400 * 1'000'000;  // [us]; told in creep.proto

}  // namespace

absl::Status Upkeep::begin() {
  if (auto status = finish_deletions(); !status.ok()) return status;
  remove_stray_folders();
  return absl::OkStatus();
}

void Upkeep::turn() {
  const auto now = Clock::now();
  if (now - looked_at_storage_ < kStorageLook) return;
  looked_at_storage_ = now;
  resume_where_room();
  finish_deletions().IgnoreError();
  if (forgot_requests_ == Clock::time_point{} || now - forgot_requests_ >= kRequestLook) {
    forgot_requests_ = now;
    store_.forget_requests_before(wall_clock() - kRequestsKept).IgnoreError();
  }
  store_.shrink().IgnoreError();
}

absl::Status Upkeep::finish_deletions() {
  const auto deleted = store_.marked_deleted();
  if (!deleted.ok()) return deleted.status();
  std::vector<std::string> gone;
  for (const std::string& id : *deleted) {
    std::error_code error;
    fs::remove_all(jobs_ / id, error);
    if (!error) gone.push_back(id);
  }
  if (gone.empty() || !creep::sync_directory(jobs_).ok()) return absl::OkStatus();
  return store_.forget(gone);
}

void Upkeep::remove_stray_folders() {
  std::error_code error;
  for (fs::directory_iterator entry(jobs_, error), end; !error && entry != end; entry.increment(error)) {
    const std::string id = entry->path().filename().string();
    if (!absl::IsNotFound(store_.get(id).status())) continue;
    // Only what was never acknowledged goes by itself: a folder in which no worker has been.
    if (fs::exists(creep::JobDirectory(entry->path()).lease(), error)) {
      log_line(absl::StrCat(entry->path().string(), " belongs to no job and is left alone"));
    } else {
      fs::remove_all(entry->path(), error);
    }
  }
}

void Upkeep::resume_where_room() {
  if (!store_.restore_reserve()) return;
  const auto paused = store_.paused(StateReason::kDiskFull);
  if (!paused.ok()) return;
  for (const Job& job : *paused) {
    if (job.not_before > wall_clock() || !has_room_for_attempt(jobs_ / job.id)) continue;
    const auto resumed = store_.change(job.id, [](Job& row) {
      if (row.state != JobState::kPaused || row.reason != StateReason::kDiskFull) return absl::OkStatus();
      row.state = JobState::kQueued;
      row.reason = StateReason::kResumed;
      row.message = "there is room again";
      return absl::OkStatus();
    });
    if (resumed.ok()) log_line(absl::StrCat("job ", job.id, ": there is room again, it goes on"));
  }
}

}  // namespace creepd
