#include "server/execution/attempt_files.h"

#include <sys/stat.h>

#include "core/folder/durable_file.h"
#include "core/folder/job_directory.h"
#include "server/folders/job_files.h"

namespace creepd {

std::optional<creep::Ending> verdict_of(const std::filesystem::path& folder, std::int64_t attempt) {
  if (verdict_attempt(folder) != attempt) return std::nullopt;
  return creep::read_verdict(creep::JobDirectory(folder).verdict());
}

AttemptEnd end_in_folder(const std::filesystem::path& folder, std::int64_t attempt) {
  AttemptEnd end;
  end.verdict = verdict_of(folder, attempt);
  end.disk_full = !has_room_for_attempt(folder);
  end.checkpoint = newest_checkpoint(folder);
  end.state_digest = state_digest(folder);
  end.log_tail = log_tail(folder);
  return end;
}

absl::StatusOr<JobStore::Telling> progress_in_folder(const std::string& job,
                                                     const std::filesystem::path& folder,
                                                     SampleIndex& samples) {
  const auto count = samples.poll();
  if (!count.ok()) return count.status();
  const auto progress = creep::read_file(creep::JobDirectory(folder).progress(), 1 << 16);
  JobStore::Telling news{job, *count, {}, progress.ok() ? *progress : std::string()};
  if (*count > 0) {
    const auto latest = samples.read(*count - 1);
    if (!latest.ok()) return latest.status();
    news.latest_sample = creep::encode(*latest);
  }
  return news;
}

std::int64_t progress_mark(const std::filesystem::path& folder) {
  struct stat about {};
  if (::stat(creep::JobDirectory(folder).progress().c_str(), &about) != 0) return 0;
  return about.st_mtim.tv_sec * 1'000'000'000 + about.st_mtim.tv_nsec;
}

bool has_room_for_attempt(const std::filesystem::path& folder) {
  return free_bytes(folder.parent_path()) >= needed_bytes(folder);
}

}  // namespace creepd
