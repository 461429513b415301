// The jobs of a sweep on this machine, each in a folder of its own, several at a time.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "client/sweep/sweep_end.h"
#include "client/sweep/sweep_plan.h"

namespace creepctl {

struct LocalSweepOptions {
  std::filesystem::path out;
  std::string job_path;  ///< for messages
  int at_once = 1;       ///< workers
  int threads = 1;       ///< of each
};

/// Whether the folder can take the sweep; changes nothing. Error: FailedPrecondition (it, or the folder of
/// one of the jobs, holds something else), Unavailable (cannot be read).
absl::Status check_sweep_folder(const std::vector<SweepJob>& jobs, const LocalSweepOptions& options);

/// Runs what is not done yet. A branch begins as soon as its trunk keeps its checkpoint, whether the trunk
/// goes on or failed later; a job that fails stops no other. SIGINT and SIGTERM make all workers checkpoint
/// and end. `say` is told in a line what begins and ends. The ends are in the order of the plan.
std::vector<SweepEnd> sweep_locally(const std::vector<SweepJob>& jobs, const LocalSweepOptions& options,
                                    const std::function<void(const std::string&)>& say);

}  // namespace creepctl
