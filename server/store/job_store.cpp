#include "server/store/job_store.h"

#include <mutex>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "core/arithmetic/check.h"
#include "server/folders/job_files.h"
#include "server/host/reserve.h"
#include "server/host/wall_clock.h"
#include "server/rules/refusal.h"
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

}  // namespace

struct JobStore::Impl {
  explicit Impl(const std::filesystem::path& path)
      : folder(path.parent_path()), reserve(folder / "reserve") {}

  std::filesystem::path folder;
  Reserve reserve;
  std::mutex mutex;
  std::unique_ptr<Database> database;  // never null once open
  std::function<void(const std::string&)> listener;
  bool deletions_pending = true;  // false: no row has deleted=1; looking for one reads the whole table

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
                             bool& event) {
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
    if (auto status = transaction.commit(); !status.ok()) return status;
    return job;
  }
};

JobStore::JobStore(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
JobStore::~JobStore() = default;

absl::StatusOr<std::unique_ptr<JobStore>> JobStore::open(const std::filesystem::path& path) {
  auto impl = std::make_unique<Impl>(path);
  auto database = impl->with_reserve([&] { return Database::open(path); });
  if (!database.ok()) return database.status();
  impl->database = *std::move(database);
  impl->reserve.restore();
  return std::unique_ptr<JobStore>(new JobStore(std::move(impl)));
}

void JobStore::on_change(std::function<void(const std::string&)> listener) {
  impl_->listener = std::move(listener);
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

absl::StatusOr<std::vector<Job>> JobStore::list(const ListQuery& query) {
  std::string rest;
  if (!query.owner.empty()) rest += "AND owner=? ";
  if (query.before_number > 0) rest += "AND number<? ";
  if (!query.states.empty()) {
    rest += "AND state IN (" +
            absl::StrJoin(
                query.states, ",",
                [](std::string* out, JobState state) { absl::StrAppend(out, static_cast<int>(state)); }) +
            ") ";
  }
  for (std::size_t i = 0; i < query.labels.size(); ++i) {
    rest += "AND EXISTS (SELECT 1 FROM label WHERE label.job=job.number AND key=? AND value=?) ";
  }
  rest += "ORDER BY number DESC LIMIT ?";
  const std::lock_guard lock(impl_->mutex);
  Statement rows(*impl_->database, select_jobs(Spec::kWithout, rest));
  if (!query.owner.empty()) rows.bind(query.owner);
  if (query.before_number > 0) rows.bind(query.before_number);
  for (const auto& [key, value] : query.labels) rows.bind(key).bind(value);
  rows.bind(query.limit);
  return read_jobs(*impl_->database, rows);
}

absl::StatusOr<Job> JobStore::change(const std::string& id, const std::function<absl::Status(Job&)>& change) {
  bool event = false;
  absl::StatusOr<Job> job;
  {
    const std::lock_guard lock(impl_->mutex);
    job = impl_->with_reserve([&] { return impl_->change(id, change, event); });
  }
  if (job.ok() && event && impl_->listener) impl_->listener(id);
  return job;
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
  if (!impl_->listener) return absl::OkStatus();
  for (const Telling& one : news) impl_->listener(one.id);
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

absl::Status JobStore::mark_deleted(const std::string& id) {
  {
    const std::lock_guard lock(impl_->mutex);
    const auto job = impl_->read(id);
    if (!job.ok()) return job.status();
    impl_->deletions_pending = true;
    const auto mark = [&] {
      return Statement(*impl_->database, "UPDATE job SET deleted=1 WHERE id=? AND state NOT IN (1,2)")
          .bind(id)
          .run();
    };
    if (auto status = impl_->with_reserve(mark); !status.ok()) return status;
    if (impl_->database->rows_changed() == 0) {
      return refuse(absl::StatusCode::kFailedPrecondition,
                    absl::StrCat("job ", id, " is ", state_name(job->state), "; cancel it first"),
                    {"WRONG_STATE", {{"state", state_name(job->state)}}, {}, {}});
    }
  }
  if (impl_->listener) impl_->listener(id);
  return absl::OkStatus();
}

absl::Status JobStore::forget(const std::string& id) {
  const std::lock_guard lock(impl_->mutex);
  return impl_->with_reserve(
      [&] { return Statement(*impl_->database, "DELETE FROM job WHERE id=? AND deleted=1").bind(id).run(); });
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

bool JobStore::use_reserve() {
  const std::lock_guard lock(impl_->mutex);
  return impl_->use_reserve();
}

bool JobStore::restore_reserve() {
  const std::lock_guard lock(impl_->mutex);
  return impl_->reserve.restore();
}

}  // namespace creepd
