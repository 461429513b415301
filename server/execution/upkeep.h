// What a daemon does for its store and folders beside running jobs: it finishes deletions, takes up jobs that
// waited for room, forgets what nobody asks for any more and gives room back.
#pragma once

#include <chrono>
#include <filesystem>

#include "absl/status/status.h"
#include "server/store/job_store.h"

namespace creepd {

class Upkeep {
 public:
  Upkeep(std::filesystem::path jobs, JobStore& store) : jobs_(std::move(jobs)), store_(store) {}

  /// What a daemon that is gone has left undone. Before anybody else uses the store.
  absl::Status begin();

  /// Does what is due; to be called as often as one likes. What fails is tried again.
  void turn();

 private:
  using Clock = std::chrono::steady_clock;

  absl::Status finish_deletions();
  void remove_stray_folders();
  void resume_where_room();

  std::filesystem::path jobs_;
  JobStore& store_;
  Clock::time_point looked_at_storage_{};
  Clock::time_point forgot_requests_{};
};

}  // namespace creepd
