// One attempt at the job of one directory, from taking the lease to the verdict.
//
//   lease -> job.toml -> samples.log -> newest good checkpoint -> { advance -> append -> checkpoint } ->
//   verdict.json
//
// Order within a turn: records are appended; before a checkpoint becomes visible, the log is made durable. So
// the log is never behind the newest checkpoint, and a resumed run finds what it repeats.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "server/worker/stop_request.h"

namespace creepd {

struct WorkerOptions {
  std::filesystem::path directory;
  int threads = 1;
  std::string instruction_set;  ///< "" = the widest the processor has
  bool allow_inexact = false;
  std::optional<std::int64_t> attempt;  ///< default: one more than the last
  double checkpoint_interval = 30.0;    ///< [s] of wall time between checkpoints at most
  bool profile = false;                 ///< look where the time goes, write profile.csv
  std::int64_t rebuild_every = 0;       ///< neighbour search every so many cycles (tests); 0 = when due
};

/// Computes until the job is done, fails or is asked to stop. Returns the exit code (ending.h).
int work(const WorkerOptions& options, StopRequest& stop);

}  // namespace creepd
