// Plans of jobs, from pilots that run as jobs themselves.
#pragma once

#include <filesystem>
#include <string>

#include "absl/status/statusor.h"
#include "core/plan/plan.h"

namespace creepd {

/// The job file of the pilot. Errors: of check_spec(); InvalidArgument BAD_REQUEST (the job has [start]).
absl::StatusOr<std::string> pilot_spec(const std::string& spec);

struct JobPlan {
  creep::Plan plan;
  creep::Pilot pilot;
};

/// From what a pilot that has ended left in its folder. `spec` is that of the job. Error: InvalidArgument (a
/// table cannot be read), or of the file system.
absl::StatusOr<JobPlan> read_job_plan(const std::string& spec, const std::filesystem::path& pilot_folder,
                                      const std::string& reason);

}  // namespace creepd
