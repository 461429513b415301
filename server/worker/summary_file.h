// summary.json: what a finished job found, and with what it was found.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "absl/status/status.h"
#include "core/folder/ending.h"
#include "core/run/run.h"
#include "server/worker/stage_timings.h"

namespace creepd {

struct SummaryFacts {
  std::string experiment_hash;
  creep::Numerics numerics;
  std::string instruction_set;
  int threads = 1;
  std::int64_t attempts = 1;
  Cost total;  ///< of all attempts
};

/// Durable. Figures and state_digest depend on the experiment alone; cost, attempts and versions do not.
absl::Status write_summary(const std::filesystem::path& path, const creep::Run& run,
                           const creep::Ending& ending, const SummaryFacts& facts);

}  // namespace creepd
