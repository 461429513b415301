#include "server/store/job_store.h"

#include <iterator>
#include <mutex>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "core/arithmetic/check.h"
#include "server/folders/job_files.h"
#include "server/host/reserve.h"
#include "server/host/wall_clock.h"
#include "server/rules/refusal.h"
#include "server/store/attempt_rows.h"
#include "server/store/database.h"
#include "server/store/job_rows.h"

namespace creepd {
namespace {

constexpr std::uint64_t kAlmostFull = 1 << 20;  // more than one change needs [bytes]

const absl::Status& status_of(const absl::Status& status) { return status; }
template <typename Value>
const absl::Status& status_of(const absl::StatusOr<Value>& value) {
  return value.status();
}

constexpr JobState kAllStates[] = {JobState::kQueued,    JobState::kRunning, JobState::kPaused,
                                   JobState::kSucceeded, JobState::kFailed,  JobState::kCancelled};

/// The page is found by indices alone, a state at a time, so that jobs that are not on it are never read.
std::string list_sql(const ListQuery& query) {
  std::string conditions = "deleted=0 AND state=? ";
  if (!query.owner.empty()) conditions += "AND owner=? ";
  if (query.before_number > 0) conditions += "AND number<? ";
  for (std::size_t i = 0; i < query.labels.size(); ++i) {
    conditions += "AND number IN (SELECT job FROM label WHERE key=? AND value=?) ";
  }
  const std::vector<std::string> of_each(query.states.size(), "SELECT number FROM job WHERE " + conditions);
  return select_jobs(Spec::kWithout, absl::StrCat("AND number IN (", absl::StrJoin(of_each, "UNION ALL "),
                                                  "ORDER BY number DESC LIMIT ?) ORDER BY number DESC"));
}

}  // namespace

struct JobStore::Impl {
  Impl(const std::filesystem::path& path, std::function<void(const std::string&)> changed)
      : folder(path.parent_path()), reserve(folder / "reserve"), changed(std::move(changed)) {}

  std::filesystem::path folder;
  Reserve reserve;
  const std::function<void(const std::string&)> changed;
  std::mutex mutex;
  std::unique_ptr<Database> database;  // never null once open
  bool deletions_pending = true;       // false: no row has deleted=1; looking for one reads the whole table

  void tell_changed(const std::string& id) const {
    if (changed) changed(id);
  }

  bool use_reserve() { return free_bytes(folder) < kAlmostFull && reserve.use(); }

  /// A write; once more with the room of the reserve if the disk is full.
  template <typename Write>
  auto with_reserve(const Write& write) {
    auto result = write();
    if (absl::IsUnavailable(status_of(result)) && use_reserve()) result = write();
    return result;
  }

  absl::StatusOr<Job> read(const std::string& id) { return read_job(*database, id); }

  absl::StatusOr<std::optional<Job>> find_request(const std::string& owner, const RequestKey& key) {
    if (key.id.empty()) return std::optional<Job>();
    Statement row(*database, "SELECT content,job FROM request WHERE owner=? AND request_id=?");
    row.bind(owner).bind(key.id);
    const bool found = row.step();
    if (auto status = row.status(); !status.ok()) return status;
    if (!found) return std::optional<Job>();
    const std::string content = row.text();
    const std::string id = row.text();
    const Refusal reused{"REQUEST_ID_REUSED", {{"job", id}}, {}, {}};
    if (content != key.content) {
      return refuse(absl::StatusCode::kInvalidArgument,
                    absl::StrCat("request_id was used for another request, which made job ", id), reused);
    }
    auto job = read(id);
    if (absl::IsNotFound(job.status())) {
      return refuse(absl::StatusCode::kInvalidArgument,
                    absl::StrCat("request_id made job ", id, ", which was deleted since"), reused);
    }
    if (!job.ok()) return job.status();
    return std::optional<Job>(*std::move(job));
  }

  absl::Status insert(Job& job, const RequestKey& key) {
    if (auto status = insert_job(*database, job); !status.ok()) return status;
    if (key.id.empty()) return absl::OkStatus();
    Statement row(*database, "INSERT INTO request VALUES (?,?,?,?,?)");
    return row.bind(job.owner).bind(key.id).bind(key.content).bind(job.id).bind(wall_clock()).run();
  }

  /// `event`: whether watchers want to know.
  absl::StatusOr<Job> change(const std::string& id, const std::function<absl::Status(Job&)>& change,
                             const Attempt* attempt, bool& event) {
    Transaction transaction(*database);
    if (auto status = transaction.status(); !status.ok()) return status;
    auto job = read(id);
    if (!job.ok()) return job.status();
    const JobState state = job->state;
    const StateReason reason = job->reason;
    const std::uint64_t samples = job->samples;
    if (auto status = change(*job); !status.ok()) return status;
    CREEP_CHECK(job->samples >= samples, "told samples never become fewer");
    event = job->state != state || job->reason != reason;
    if (event) {
      CREEP_CHECK(is_legal(state, job->state), "a job changes state by the table");
      if (auto status = add_event(*database, *job); !status.ok()) return status;
    }
    if (auto status = update_job(*database, *job); !status.ok()) return status;
    if (attempt != nullptr) {
      if (auto status = put_attempt(*database, job->number, *attempt); !status.ok()) return status;
    }
    if (auto status = transaction.commit(); !status.ok()) return status;
    return job;
  }

  absl::StatusOr<std::int64_t> number_of(const std::string& id) {
    Statement row(*database, "SELECT number FROM job WHERE id=? AND deleted=0");
    row.bind(id);
    const bool found = row.step();
    if (auto status = row.status(); !status.ok()) return status;
    if (!found) return job_not_found(id);
    return row.integer();
  }

  absl::Status mark_deleted(const std::string& id) {
    Statement row(*database, "UPDATE job SET deleted=1 WHERE id=? AND deleted=0 AND state NOT IN (1,2)");
    if (auto status = row.bind(id).run(); !status.ok()) return status;
    if (database->rows_changed() > 0) return absl::OkStatus();
    const auto job = read(id);
    if (!job.ok()) return job.status();
    return refuse(absl::StatusCode::kFailedPrecondition,
                  absl::StrCat("job ", id, " is ", state_name(job->state), "; cancel it first"),
                  {"WRONG_STATE", {{"state", state_name(job->state)}}, {}, {}});
  }

  /// An error of the storage, which undoes all, or one status a job.
  absl::StatusOr<std::vector<absl::Status>> mark_deleted(const std::vector<std::string>& ids) {
    Transaction transaction(*database);
    if (auto status = transaction.status(); !status.ok()) return status;
    std::vector<absl::Status> marked;
    for (const std::string& id : ids) {
      marked.push_back(mark_deleted(id));
      if (absl::IsUnavailable(marked.back())) return marked.back();
    }
    if (auto status = transaction.commit(); !status.ok()) return status;
    return marked;
  }

  absl::Status forget(const std::vector<std::string>& ids) {
    Transaction transaction(*database);
    if (auto status = transaction.status(); !status.ok()) return status;
    Statement row(*database, "DELETE FROM job WHERE id=? AND deleted=1");
    for (const std::string& id : ids) {
      if (auto status = row.again().bind(id).run(); !status.ok()) return status;
    }
    return transaction.commit();
  }
};

JobStore::JobStore(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
JobStore::~JobStore() = default;

absl::StatusOr<std::unique_ptr<JobStore>> JobStore::open(const std::filesystem::path& path,
                                                         std::function<void(const std::string&)> changed) {
  auto impl = std::make_unique<Impl>(path, std::move(changed));
  auto database = impl->with_reserve([&] { return Database::open(path); });
  if (!database.ok()) return database.status();
  impl->database = *std::move(database);
  impl->reserve.restore();
  return std::unique_ptr<JobStore>(new JobStore(std::move(impl)));
}

absl::StatusOr<std::optional<Job>> JobStore::find_request(const std::string& owner, const RequestKey& key) {
  const std::lock_guard lock(impl_->mutex);
  return impl_->find_request(owner, key);
}

absl::StatusOr<JobStore::Inserted> JobStore::insert(Job job, const RequestKey& key,
                                                    std::int64_t most_unfinished) {
  const std::lock_guard lock(impl_->mutex);
  Transaction transaction(*impl_->database);
  if (auto status = transaction.status(); !status.ok()) return status;
  auto earlier = impl_->find_request(job.owner, key);
  if (!earlier.ok()) return earlier.status();
  if (*earlier) return Inserted{**std::move(earlier), true};
  const auto unfinished = impl_->database->number("SELECT count(*) FROM job WHERE state IN (1,2,3)");
  if (!unfinished.ok()) return unfinished.status();
  if (*unfinished >= most_unfinished) {
    return refuse(absl::StatusCode::kResourceExhausted,
                  absl::StrCat("the queue is full: ", *unfinished, " jobs are not finished"),
                  {"QUEUE_FULL", {{"limit", absl::StrCat(most_unfinished)}}, {}, 60});
  }
  if (auto status = impl_->insert(job, key); !status.ok()) return status;
  if (auto status = transaction.commit(); !status.ok()) return status;
  return Inserted{std::move(job), false};
}

absl::StatusOr<Job> JobStore::get(const std::string& id) {
  const std::lock_guard lock(impl_->mutex);
  return impl_->read(id);
}

absl::StatusOr<std::vector<Job>> JobStore::list(ListQuery query) {
  if (query.states.empty()) query.states.assign(std::begin(kAllStates), std::end(kAllStates));
  const std::lock_guard lock(impl_->mutex);
  Statement rows(*impl_->database, list_sql(query));
  for (const JobState state : query.states) {
    rows.bind(state);
    if (!query.owner.empty()) rows.bind(query.owner);
    if (query.before_number > 0) rows.bind(query.before_number);
    for (const auto& [key, value] : query.labels) rows.bind(key).bind(value);
  }
  rows.bind(query.limit);
  return read_jobs(*impl_->database, rows);
}

absl::StatusOr<Job> JobStore::change(const std::string& id, const std::function<absl::Status(Job&)>& change,
                                     const Attempt* attempt) {
  bool event = false;
  absl::StatusOr<Job> job;
  {
    const std::lock_guard lock(impl_->mutex);
    job = impl_->with_reserve([&] { return impl_->change(id, change, attempt, event); });
  }
  if (job.ok() && event) impl_->tell_changed(id);
  return job;
}

absl::Status JobStore::note(const std::string& id, const Attempt& attempt) {
  const std::lock_guard lock(impl_->mutex);
  const auto job = impl_->number_of(id);
  return job.ok() ? put_attempt(*impl_->database, *job, attempt) : job.status();
}

absl::StatusOr<std::vector<Attempt>> JobStore::attempts(const std::string& id, std::int64_t first,
                                                        int limit) {
  const std::lock_guard lock(impl_->mutex);
  const auto job = impl_->number_of(id);
  if (!job.ok()) return job.status();
  return read_attempts(*impl_->database, *job, first, limit);
}

absl::Status JobStore::tell(const std::vector<Telling>& news) {
  {
    const std::lock_guard lock(impl_->mutex);
    Transaction transaction(*impl_->database);
    if (auto status = transaction.status(); !status.ok()) return status;
    for (const Telling& one : news) {
      Statement row(*impl_->database,
                    "UPDATE job SET samples=max(samples,?),latest_sample=?,progress=? WHERE id=?");
      row.bind(one.samples).bind_blob(one.latest_sample).bind(one.progress).bind(one.id);
      if (auto status = row.run(); !status.ok()) return status;
    }
    if (auto status = transaction.commit(); !status.ok()) return status;
  }
  for (const Telling& one : news) impl_->tell_changed(one.id);
  return absl::OkStatus();
}

absl::StatusOr<JobStore::Events> JobStore::events(const std::string& id, std::uint64_t from_place) {
  const std::lock_guard lock(impl_->mutex);
  Statement jobs(*impl_->database, select_jobs(Spec::kWithout, "AND id=?"));
  jobs.bind(id);
  if (!jobs.step()) return jobs.status().ok() ? job_not_found(id) : jobs.status();
  Job job = job_in(jobs);
  auto changes = read_events(*impl_->database, job, from_place);
  if (!changes.ok()) return changes.status();
  return Events{std::move(job), *std::move(changes)};
}

absl::StatusOr<std::optional<Job>> JobStore::next_queued(Moment now) {
  const std::lock_guard lock(impl_->mutex);
  Statement rows(
      *impl_->database,
      select_jobs(Spec::kWithout, "AND state=1 AND not_before<=? ORDER BY priority DESC, number LIMIT 1"));
  rows.bind(now);
  if (!rows.step())
    return rows.status().ok() ? absl::StatusOr<std::optional<Job>>(std::optional<Job>()) : rows.status();
  return std::optional<Job>(job_in(rows));
}

absl::StatusOr<std::vector<Job>> JobStore::running() {
  const std::lock_guard lock(impl_->mutex);
  Statement rows(*impl_->database, select_jobs(Spec::kWithout, "AND state=2 ORDER BY number"));
  return read_jobs(*impl_->database, rows);
}

absl::StatusOr<std::vector<Job>> JobStore::paused(StateReason reason) {
  const std::lock_guard lock(impl_->mutex);
  Statement rows(*impl_->database, select_jobs(Spec::kWithout, "AND state=3 AND reason=? ORDER BY number"));
  rows.bind(reason);
  return read_jobs(*impl_->database, rows);
}

absl::StatusOr<Counts> JobStore::counts() {
  const std::lock_guard lock(impl_->mutex);
  Statement rows(*impl_->database, "SELECT state,count(*) FROM job WHERE state IN (1,2,3) GROUP BY state");
  Counts counts;
  while (rows.step()) {
    const auto state = static_cast<JobState>(rows.integer());
    const std::int64_t count = rows.integer();
    counts.unfinished += count;
    if (state == JobState::kQueued) counts.queued = count;
    if (state == JobState::kRunning) counts.running = count;
  }
  if (auto status = rows.status(); !status.ok()) return status;
  return counts;
}

// Both are answered by the index job_by_state alone, however long the jobs are. A queued job is never
// deleted.
absl::StatusOr<std::int64_t> JobStore::queue_position(const Job& job) {
  const std::lock_guard lock(impl_->mutex);
  Statement row(*impl_->database,
                "SELECT (SELECT count(*) FROM job WHERE state=1 AND priority>?1) + "
                "(SELECT count(*) FROM job WHERE state=1 AND priority=?1 AND number<=?2)");
  row.bind(job.priority).bind(job.number);
  const bool found = row.step();
  if (auto status = row.status(); !status.ok()) return status;
  return found ? row.integer() : 0;
}

absl::StatusOr<std::unordered_map<std::int64_t, std::int64_t>> JobStore::queue_positions() {
  const std::lock_guard lock(impl_->mutex);
  Statement rows(*impl_->database, "SELECT number FROM job WHERE state=1 ORDER BY priority DESC, number");
  std::unordered_map<std::int64_t, std::int64_t> positions;
  std::int64_t position = 0;
  while (rows.step()) positions[rows.integer()] = ++position;
  if (auto status = rows.status(); !status.ok()) return status;
  return positions;
}

std::vector<absl::Status> JobStore::mark_deleted(const std::vector<std::string>& ids) {
  absl::StatusOr<std::vector<absl::Status>> marked;
  {
    const std::lock_guard lock(impl_->mutex);
    impl_->deletions_pending = true;
    marked = impl_->with_reserve([&] { return impl_->mark_deleted(ids); });
  }
  if (!marked.ok()) return std::vector<absl::Status>(ids.size(), marked.status());
  for (std::size_t i = 0; i < ids.size(); ++i) {
    if ((*marked)[i].ok()) impl_->tell_changed(ids[i]);
  }
  return *std::move(marked);
}

absl::Status JobStore::forget(const std::vector<std::string>& ids) {
  const std::lock_guard lock(impl_->mutex);
  return impl_->with_reserve([&] { return impl_->forget(ids); });
}

absl::StatusOr<std::vector<std::string>> JobStore::marked_deleted() {
  const std::lock_guard lock(impl_->mutex);
  std::vector<std::string> ids;
  if (!impl_->deletions_pending) return ids;
  Statement rows(*impl_->database, "SELECT id FROM job WHERE deleted=1");
  while (rows.step()) ids.push_back(rows.text());
  if (auto status = rows.status(); !status.ok()) return status;
  impl_->deletions_pending = !ids.empty();
  return ids;
}

absl::Status JobStore::forget_requests_before(Moment moment) {
  const std::lock_guard lock(impl_->mutex);
  return impl_->with_reserve(
      [&] { return Statement(*impl_->database, "DELETE FROM request WHERE moment<?").bind(moment).run(); });
}

absl::Status JobStore::shrink() {
  constexpr std::int64_t kSpare = 256;  // of 4 KiB: what the next jobs need
  constexpr std::int64_t kMost = 1024;
  const std::lock_guard lock(impl_->mutex);
  return impl_->database->give_back(kSpare, kMost).status();
}

bool JobStore::use_reserve() {
  const std::lock_guard lock(impl_->mutex);
  return impl_->use_reserve();
}

bool JobStore::restore_reserve() {
  const std::lock_guard lock(impl_->mutex);
  return impl_->reserve.restore();
}

}  // namespace creepd
