#include "server/store/job_rows.h"

#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "absl/strings/str_split.h"
#include "server/host/wall_clock.h"
#include "server/rules/refusal.h"

namespace creepd {
namespace {

// Both orders are those of job_in(); the first is that of bind_mutable() too.
constexpr const char* kMutable =
    "state,reason,message,log_tail,state_digest,started,ended,attempts,lease_attempt,faults,losses,"
    "checkpoint,not_before,stop_now,samples,events,latest_sample,progress";
constexpr const char* kFixed =
    "number,id,owner,name,priority,warnings,experiment_hash,memory_estimate,parent,parent_generation,"
    "submitted";

void bind_mutable(Statement& statement, const Job& job) {
  statement.bind(job.state).bind(job.reason).bind(job.message).bind(job.log_tail).bind(job.state_digest);
  statement.bind(job.started).bind(job.ended).bind(job.attempts).bind(job.lease_attempt);
  statement.bind(job.faults).bind(job.losses).bind(job.checkpoint).bind(job.not_before);
  statement.bind(std::int64_t{job.stop_now}).bind(job.samples).bind(job.events);
  statement.bind_blob(job.latest_sample).bind(job.progress);
}

}  // namespace

std::string select_jobs(Spec spec, const std::string& rest) {
  return absl::StrCat("SELECT ", kMutable, ",", kFixed, spec == Spec::kWith ? ",spec" : ",''",
                      " FROM job WHERE deleted=0 ", rest);
}

Job job_in(Statement& row) {
  Job job;
  job.state = static_cast<JobState>(row.integer());
  job.reason = static_cast<StateReason>(row.integer());
  job.message = row.text();
  job.log_tail = row.text();
  job.state_digest = row.text();
  job.started = row.moment();
  job.ended = row.moment();
  job.attempts = row.small();
  job.lease_attempt = row.integer();
  job.faults = row.small();
  job.losses = row.small();
  job.checkpoint = row.natural();
  job.not_before = row.integer();
  job.stop_now = row.integer() != 0;
  job.samples = row.natural();
  job.events = row.natural();
  job.latest_sample = row.text();
  job.progress = row.text();
  job.number = row.integer();
  job.id = row.text();
  job.owner = row.text();
  job.name = row.text();
  job.priority = row.small();
  const std::string warnings = row.text();
  if (!warnings.empty()) job.warnings = absl::StrSplit(warnings, '\n');
  job.experiment_hash = row.text();
  job.memory_estimate = row.natural();
  job.parent = row.text();
  job.parent_generation = row.natural();
  job.submitted = row.integer();
  job.spec = row.text();
  return job;
}

absl::StatusOr<std::vector<Job>> read_jobs(Database& database, Statement& rows) {
  std::vector<Job> jobs;
  while (rows.step()) jobs.push_back(job_in(rows));
  if (auto status = rows.status(); !status.ok()) return status;
  if (jobs.empty()) return jobs;
  Statement labels(database, "SELECT key,value FROM label WHERE job=?");
  for (Job& job : jobs) {
    labels.again().bind(job.number);
    while (labels.step()) {
      std::string key = labels.text();
      job.labels[std::move(key)] = labels.text();
    }
    if (auto status = labels.status(); !status.ok()) return status;
  }
  return jobs;
}

absl::StatusOr<Job> read_job(Database& database, const std::string& id) {
  Statement rows(database, select_jobs(Spec::kWith, "AND id=?"));
  rows.bind(id);
  auto jobs = read_jobs(database, rows);
  if (!jobs.ok()) return jobs.status();
  if (jobs->empty()) return job_not_found(id);
  return std::move(jobs->front());
}

absl::Status insert_job(Database& database, Job& job) {
  Statement statement(database,
                      absl::StrCat("INSERT INTO job (", kMutable,
                                   ",id,owner,name,priority,warnings,experiment_hash,memory_estimate,parent,"
                                   "parent_generation,submitted,spec) VALUES "
                                   "(?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?)"));
  job.events = 1;
  bind_mutable(statement, job);
  job.events = 0;
  statement.bind(job.id).bind(job.owner).bind(job.name).bind(job.priority);
  statement.bind(absl::StrJoin(job.warnings, "\n")).bind(job.experiment_hash).bind(job.memory_estimate);
  statement.bind(job.parent).bind(job.parent_generation).bind(job.submitted).bind(job.spec);
  if (auto status = statement.run(); !status.ok()) return status;
  job.number = database.last_row();
  if (auto status = add_event(database, job); !status.ok()) return status;
  for (const auto& [label, value] : job.labels) {
    Statement row(database, "INSERT INTO label VALUES (?,?,?)");
    if (auto status = row.bind(job.number).bind(label).bind(value).run(); !status.ok()) return status;
  }
  return absl::OkStatus();
}

absl::Status update_job(Database& database, const Job& job) {
  Statement statement(database, absl::StrCat("UPDATE job SET (", kMutable,
                                             ")=(?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?) WHERE number=?"));
  bind_mutable(statement, job);
  return statement.bind(job.number).run();
}

absl::Status add_event(Database& database, Job& job) {
  Statement statement(database, "INSERT INTO event VALUES (?,?,?,?,?,?,?,?)");
  statement.bind(job.number).bind(job.events).bind(job.samples).bind(job.state).bind(job.reason);
  statement.bind(job.message).bind(job.attempts).bind(wall_clock());
  ++job.events;
  return statement.run();
}

absl::StatusOr<std::vector<StateEvent>> read_events(Database& database, const Job& job,
                                                    std::uint64_t from_place) {
  Statement rows(database,
                 "SELECT samples_before,state,reason,message,attempt,moment FROM event WHERE job=? AND "
                 "place>=? ORDER BY place");
  rows.bind(job.number).bind(from_place);
  std::vector<StateEvent> events;
  while (rows.step()) {
    StateEvent event;
    event.samples_before = rows.natural();
    event.state = static_cast<JobState>(rows.integer());
    event.reason = static_cast<StateReason>(rows.integer());
    event.message = rows.text();
    event.attempt = rows.small();
    event.moment = rows.integer();
    events.push_back(std::move(event));
  }
  if (auto status = rows.status(); !status.ok()) return status;
  return events;
}

}  // namespace creepd
