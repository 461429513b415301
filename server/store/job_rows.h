// Jobs and their changes of state as rows of the tables `job`, `label` and `event` (schema.sql).
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "server/rules/job.h"
#include "server/store/database.h"

namespace creepd {

enum class Spec : std::uint8_t { kWith, kWithout };

/// A query of jobs that are not deleted; `rest` is "AND ...", and what follows conditions.
std::string select_jobs(Spec spec, const std::string& rest);

/// The job in the present row of such a query, without its labels.
Job job_in(Statement& row);

/// All jobs of such a query, with their labels.
absl::StatusOr<std::vector<Job>> read_jobs(Database& database, Statement& rows);

/// Errors: NotFound JOB_NOT_FOUND.
absl::StatusOr<Job> read_job(Database& database, const std::string& id);

/// A new job, with its labels and its present state as its first event. Sets its number.
absl::Status insert_job(Database& database, Job& job);

/// What of a job may change.
absl::Status update_job(Database& database, const Job& job);

/// The state of the job as its next event, which it counts.
absl::Status add_event(Database& database, Job& job);

absl::StatusOr<std::vector<StateEvent>> read_events(Database& database, const Job& job,
                                                    std::uint64_t from_place);

}  // namespace creepd
