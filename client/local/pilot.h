// Runs the pilot of a job here and now.
#pragma once

#include "absl/status/statusor.h"
#include "client/job_file/job_file.h"
#include "core/plan/pilot.h"

namespace creepctl {

/// Its folder is a temporary one that is removed. Errors: of creep::pilot_text(), Unavailable (no worker, no
/// folder), Aborted (stopped by a guard or a signal).
absl::StatusOr<creep::Pilot> run_pilot(const JobFile& job, int threads);

}  // namespace creepctl
