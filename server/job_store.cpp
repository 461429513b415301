#include "server/job_store.h"

#include <sqlite3.h>

#include <chrono>
#include <mutex>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "absl/strings/str_split.h"
#include "core/arithmetic/check.h"
#include "server/job_files.h"
#include "server/refusal.h"
#include "server/reserve.h"
#include "server/schema.h"

namespace creepd {
namespace {

constexpr std::int64_t kSchemaVersion = 1;
constexpr std::uint64_t kAlmostFull = 1 << 20;  // more than one change needs [bytes]

absl::Status storage_failed(sqlite3* database, const char* what) {
  const std::string message = absl::StrCat("database: ", what, ": ", sqlite3_errmsg(database));
  return refuse(absl::StatusCode::kUnavailable, message, {"STORAGE_FAILED", {}, {}, 5});
}

/// One prepared statement; values are bound in order. The first error is kept and told by the end of use.
class Statement {
 public:
  Statement(sqlite3* database, const std::string& sql) : database_(database) {
    code_ = sqlite3_prepare_v2(database, sql.c_str(), static_cast<int>(sql.size() + 1), &statement_, nullptr);
  }
  Statement(const Statement&) = delete;
  Statement& operator=(const Statement&) = delete;
  ~Statement() { sqlite3_finalize(statement_); }

  Statement& bind(std::int64_t value) {
    if (code_ == SQLITE_OK) code_ = sqlite3_bind_int64(statement_, ++bound_, value);
    return *this;
  }
  Statement& bind(std::uint64_t value) { return bind(static_cast<std::int64_t>(value)); }
  Statement& bind(std::int32_t value) { return bind(std::int64_t{value}); }
  Statement& bind(JobState value) { return bind(static_cast<std::int64_t>(value)); }
  Statement& bind(const std::string& value) {
    if (code_ == SQLITE_OK) {
      code_ = sqlite3_bind_text(statement_, ++bound_, value.data(), static_cast<int>(value.size()),
                                SQLITE_TRANSIENT);
    }
    return *this;
  }
  Statement& bind_blob(const std::string& value) {
    if (code_ == SQLITE_OK) {
      code_ = sqlite3_bind_blob(statement_, ++bound_, value.data(), static_cast<int>(value.size()),
                                SQLITE_TRANSIENT);
    }
    return *this;
  }
  Statement& bind(const std::optional<Moment>& value) {
    if (value) return bind(*value);
    if (code_ == SQLITE_OK) code_ = sqlite3_bind_null(statement_, ++bound_);
    return *this;
  }

  /// Once more, with other values.
  Statement& again() {
    if (code_ == SQLITE_DONE || code_ == SQLITE_ROW) code_ = sqlite3_reset(statement_);
    bound_ = 0;
    return *this;
  }

  /// True while there is a row.
  bool step() {
    if (code_ != SQLITE_OK && code_ != SQLITE_ROW) return false;
    column_ = 0;
    code_ = sqlite3_step(statement_);
    return code_ == SQLITE_ROW;
  }
  absl::Status run() {
    while (step()) {
    }
    return status();
  }
  absl::Status status() const {
    return code_ == SQLITE_DONE || code_ == SQLITE_ROW ? absl::OkStatus()
                                                       : storage_failed(database_, "statement");
  }

  std::int64_t integer() { return sqlite3_column_int64(statement_, column_++); }
  std::int32_t small() { return static_cast<std::int32_t>(integer()); }
  std::uint64_t natural() { return static_cast<std::uint64_t>(integer()); }
  std::string text() {
    const int column = column_++;
    const void* bytes = sqlite3_column_blob(statement_, column);
    const auto size = static_cast<std::size_t>(sqlite3_column_bytes(statement_, column));
    return bytes == nullptr ? std::string() : std::string(static_cast<const char*>(bytes), size);
  }
  std::optional<Moment> moment() {
    if (sqlite3_column_type(statement_, column_) == SQLITE_NULL) {
      ++column_;
      return std::nullopt;
    }
    return integer();
  }

 private:
  sqlite3* database_;
  sqlite3_stmt* statement_ = nullptr;
  int code_ = SQLITE_OK;
  int bound_ = 0;
  int column_ = 0;
};

/// Rolled back unless committed.
class Transaction {
 public:
  explicit Transaction(sqlite3* database) : database_(database) {
    open_ = sqlite3_exec(database_, "BEGIN IMMEDIATE", nullptr, nullptr, nullptr) == SQLITE_OK;
  }
  Transaction(const Transaction&) = delete;
  Transaction& operator=(const Transaction&) = delete;
  ~Transaction() {
    if (open_) sqlite3_exec(database_, "ROLLBACK", nullptr, nullptr, nullptr);
  }
  absl::Status status() const { return open_ ? absl::OkStatus() : storage_failed(database_, "begin"); }
  absl::Status commit() {
    if (sqlite3_exec(database_, "COMMIT", nullptr, nullptr, nullptr) != SQLITE_OK) {
      return storage_failed(database_, "commit");
    }
    open_ = false;
    return absl::OkStatus();
  }

 private:
  sqlite3* database_;
  bool open_ = false;
};

// Both orders are those of read_job() and bind_job().
constexpr const char* kMutable =
    "state,reason,message,log_tail,state_digest,started,ended,attempts,lease_attempt,faults,losses,"
    "checkpoint,"
    "not_before,stop_now,samples,events,latest_sample,progress";
constexpr const char* kFixed =
    "number,id,owner,name,priority,warnings,experiment_hash,memory_estimate,parent,parent_generation,"
    "submitted";

Job read_job(Statement& row) {
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

void bind_mutable(Statement& statement, const Job& job) {
  statement.bind(job.state).bind(static_cast<std::int64_t>(job.reason)).bind(job.message).bind(job.log_tail);
  statement.bind(job.state_digest)
      .bind(job.started)
      .bind(job.ended)
      .bind(job.attempts)
      .bind(job.lease_attempt);
  statement.bind(job.faults).bind(job.losses).bind(job.checkpoint).bind(job.not_before);
  statement.bind(std::int64_t{job.stop_now}).bind(job.samples).bind(job.events);
  statement.bind_blob(job.latest_sample).bind(job.progress);
}

std::string select(bool with_spec, const std::string& rest) {
  return absl::StrCat("SELECT ", kMutable, ",", kFixed, with_spec ? ",spec" : ",''",
                      " FROM job WHERE deleted=0 ", rest);
}

const absl::Status& status_of(const absl::Status& status) { return status; }
const absl::Status& status_of(const absl::StatusOr<Job>& job) { return job.status(); }

Moment wall_clock() {
  return std::chrono::duration_cast<std::chrono::microseconds>(
             std::chrono::system_clock::now().time_since_epoch())
      .count();
}

}  // namespace

struct JobStore::Impl {
  explicit Impl(const std::filesystem::path& path)
      : folder(path.parent_path()), reserve(folder / "reserve") {}

  std::filesystem::path folder;
  Reserve reserve;
  std::mutex mutex;
  sqlite3* database = nullptr;
  std::function<void(const std::string&)> listener;
  bool deletions_pending = true;  // false: no row has deleted=1; looking for one reads the whole table

  ~Impl() {
    if (database == nullptr) return;
    sqlite3_wal_checkpoint_v2(database, nullptr, SQLITE_CHECKPOINT_TRUNCATE, nullptr, nullptr);
    sqlite3_close(database);
  }

  bool use_reserve() { return free_bytes(folder) < kAlmostFull && reserve.use(); }

  /// A write; once more with the room of the reserve if the disk is full.
  template <typename Write>
  auto with_reserve(const Write& write) {
    auto result = write();
    if (absl::IsUnavailable(status_of(result)) && use_reserve()) result = write();
    return result;
  }

  absl::Status execute(const char* sql) {
    return sqlite3_exec(database, sql, nullptr, nullptr, nullptr) == SQLITE_OK
               ? absl::OkStatus()
               : storage_failed(database, sql);
  }

  absl::StatusOr<std::int64_t> number(const std::string& sql) {
    Statement statement(database, sql);
    const bool found = statement.step();
    if (auto status = statement.status(); !status.ok()) return status;
    return found ? statement.integer() : 0;
  }

  absl::Status open(const std::filesystem::path& path) {
    constexpr int kFlags =
        SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE | SQLITE_OPEN_FULLMUTEX | SQLITE_OPEN_EXRESCODE;
    sqlite3_close(std::exchange(database, nullptr));
    if (sqlite3_open_v2(path.c_str(), &database, kFlags, nullptr) != SQLITE_OK) {
      return storage_failed(database, "open");
    }
    return set_up();
  }

  absl::Status set_up() {
    for (const char* pragma :
         {"PRAGMA journal_mode=WAL", "PRAGMA synchronous=FULL", "PRAGMA foreign_keys=ON",
          "PRAGMA busy_timeout=5000", "PRAGMA journal_size_limit=16777216", "PRAGMA trusted_schema=OFF"}) {
      if (auto status = execute(pragma); !status.ok()) return status;
    }
    Statement check(database, "PRAGMA quick_check(1)");
    const std::string verdict = check.step() ? check.text() : "no answer";
    if (verdict != "ok") return absl::DataLossError(absl::StrCat("the database is damaged: ", verdict));
    const auto version = number("PRAGMA user_version");
    if (!version.ok()) return version.status();
    if (*version > kSchemaVersion) {
      return absl::FailedPreconditionError(absl::StrCat("the database was made by a newer creepd (schema ",
                                                        *version, ", this one knows ", kSchemaVersion, ")"));
    }
    if (*version == kSchemaVersion) return absl::OkStatus();
    Transaction transaction(database);
    if (auto status = transaction.status(); !status.ok()) return status;
    if (auto status = execute(kSchema); !status.ok()) return status;
    if (auto status = execute(absl::StrCat("PRAGMA user_version=", kSchemaVersion).c_str()); !status.ok()) {
      return status;
    }
    return transaction.commit();
  }

  absl::StatusOr<std::vector<Job>> read_all(Statement& rows) {
    std::vector<Job> jobs;
    while (rows.step()) jobs.push_back(read_job(rows));
    if (auto status = rows.status(); !status.ok()) return status;
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

  absl::StatusOr<Job> read(const std::string& id) {
    Statement rows(database, select(true, "AND id=?"));
    rows.bind(id);
    auto jobs = read_all(rows);
    if (!jobs.ok()) return jobs.status();
    if (jobs->empty()) return job_not_found(id);
    return std::move(jobs->front());
  }

  absl::Status add_event(Job& job) {
    Statement statement(database, "INSERT INTO event VALUES (?,?,?,?,?,?,?,?)");
    statement.bind(job.number).bind(job.events).bind(job.samples).bind(job.state);
    statement.bind(static_cast<std::int64_t>(job.reason))
        .bind(job.message)
        .bind(job.attempts)
        .bind(wall_clock());
    ++job.events;
    return statement.run();
  }

  absl::Status update(const Job& job) {
    Statement statement(database, absl::StrCat("UPDATE job SET (", kMutable,
                                               ")=(?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?) WHERE number=?"));
    bind_mutable(statement, job);
    return statement.bind(job.number).run();
  }

  absl::StatusOr<std::optional<Job>> find_request(const std::string& owner, const RequestKey& key) {
    if (key.id.empty()) return std::optional<Job>();
    Statement row(database, "SELECT content,job FROM request WHERE owner=? AND request_id=?");
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

  absl::Status insert_rows(Job& job, const RequestKey& key) {
    Statement statement(
        database, absl::StrCat("INSERT INTO job (", kMutable,
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
    job.number = sqlite3_last_insert_rowid(database);
    if (auto status = add_event(job); !status.ok()) return status;
    for (const auto& [label, value] : job.labels) {
      Statement row(database, "INSERT INTO label VALUES (?,?,?)");
      if (auto status = row.bind(job.number).bind(label).bind(value).run(); !status.ok()) return status;
    }
    if (key.id.empty()) return absl::OkStatus();
    Statement row(database, "INSERT INTO request VALUES (?,?,?,?,?)");
    return row.bind(job.owner).bind(key.id).bind(key.content).bind(job.id).bind(wall_clock()).run();
  }

  /// `event`: whether watchers want to know.
  absl::StatusOr<Job> change(const std::string& id, const std::function<absl::Status(Job&)>& change,
                             bool& event) {
    Transaction transaction(database);
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
      if (auto status = add_event(*job); !status.ok()) return status;
    }
    if (auto status = update(*job); !status.ok()) return status;
    if (auto status = transaction.commit(); !status.ok()) return status;
    return job;
  }
};

JobStore::JobStore(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
JobStore::~JobStore() = default;

absl::StatusOr<std::unique_ptr<JobStore>> JobStore::open(const std::filesystem::path& path) {
  auto impl = std::make_unique<Impl>(path);
  if (auto status = impl->with_reserve([&] { return impl->open(path); }); !status.ok()) return status;
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
  Transaction transaction(impl_->database);
  if (auto status = transaction.status(); !status.ok()) return status;
  auto earlier = impl_->find_request(job.owner, key);
  if (!earlier.ok()) return earlier.status();
  if (*earlier) return Inserted{**std::move(earlier), true};
  const auto unfinished = impl_->number("SELECT count(*) FROM job WHERE state IN (1,2,3)");
  if (!unfinished.ok()) return unfinished.status();
  if (*unfinished >= most_unfinished) {
    return refuse(absl::StatusCode::kResourceExhausted,
                  absl::StrCat("the queue is full: ", *unfinished, " jobs are not finished"),
                  {"QUEUE_FULL", {{"limit", absl::StrCat(most_unfinished)}}, {}, 60});
  }
  if (auto status = impl_->insert_rows(job, key); !status.ok()) return status;
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
  Statement rows(impl_->database, select(false, rest));
  if (!query.owner.empty()) rows.bind(query.owner);
  if (query.before_number > 0) rows.bind(query.before_number);
  for (const auto& [key, value] : query.labels) rows.bind(key).bind(value);
  rows.bind(query.limit);
  return impl_->read_all(rows);
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
    Transaction transaction(impl_->database);
    if (auto status = transaction.status(); !status.ok()) return status;
    for (const Telling& one : news) {
      Statement row(impl_->database,
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
  Statement jobs(impl_->database, select(false, "AND id=?"));
  jobs.bind(id);
  if (!jobs.step()) return jobs.status().ok() ? job_not_found(id) : jobs.status();
  Events events{read_job(jobs), {}};
  Statement rows(
      impl_->database,
      "SELECT samples_before,state,reason,message,attempt,moment FROM event WHERE job=? AND place>=? "
      "ORDER BY place");
  rows.bind(events.job.number).bind(from_place);
  while (rows.step()) {
    StateEvent event;
    event.samples_before = rows.natural();
    event.state = static_cast<JobState>(rows.integer());
    event.reason = static_cast<StateReason>(rows.integer());
    event.message = rows.text();
    event.attempt = rows.small();
    event.moment = rows.integer();
    events.changes.push_back(std::move(event));
  }
  if (auto status = rows.status(); !status.ok()) return status;
  return events;
}

absl::StatusOr<std::optional<Job>> JobStore::next_queued(Moment now) {
  const std::lock_guard lock(impl_->mutex);
  Statement rows(impl_->database,
                 select(false, "AND state=1 AND not_before<=? ORDER BY priority DESC, number LIMIT 1"));
  rows.bind(now);
  if (!rows.step())
    return rows.status().ok() ? absl::StatusOr<std::optional<Job>>(std::optional<Job>()) : rows.status();
  return std::optional<Job>(read_job(rows));
}

absl::StatusOr<std::vector<Job>> JobStore::running() {
  const std::lock_guard lock(impl_->mutex);
  Statement rows(impl_->database, select(false, "AND state=2 ORDER BY number"));
  return impl_->read_all(rows);
}

absl::StatusOr<std::vector<Job>> JobStore::paused(StateReason reason) {
  const std::lock_guard lock(impl_->mutex);
  Statement rows(impl_->database, select(false, "AND state=3 AND reason=? ORDER BY number"));
  rows.bind(static_cast<std::int64_t>(reason));
  return impl_->read_all(rows);
}

absl::StatusOr<Counts> JobStore::counts() {
  const std::lock_guard lock(impl_->mutex);
  Statement rows(impl_->database, "SELECT state,count(*) FROM job WHERE state IN (1,2,3) GROUP BY state");
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
  Statement row(impl_->database,
                "SELECT (SELECT count(*) FROM job WHERE state=1 AND priority>?1) + "
                "(SELECT count(*) FROM job WHERE state=1 AND priority=?1 AND number<=?2)");
  row.bind(job.priority).bind(job.number);
  const bool found = row.step();
  if (auto status = row.status(); !status.ok()) return status;
  return found ? row.integer() : 0;
}

absl::StatusOr<std::unordered_map<std::int64_t, std::int64_t>> JobStore::queue_positions() {
  const std::lock_guard lock(impl_->mutex);
  Statement rows(impl_->database, "SELECT number FROM job WHERE state=1 ORDER BY priority DESC, number");
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
      return Statement(impl_->database, "UPDATE job SET deleted=1 WHERE id=? AND state NOT IN (1,2)")
          .bind(id)
          .run();
    };
    if (auto status = impl_->with_reserve(mark); !status.ok()) return status;
    if (sqlite3_changes(impl_->database) == 0) {
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
      [&] { return Statement(impl_->database, "DELETE FROM job WHERE id=? AND deleted=1").bind(id).run(); });
}

absl::StatusOr<std::vector<std::string>> JobStore::marked_deleted() {
  const std::lock_guard lock(impl_->mutex);
  std::vector<std::string> ids;
  if (!impl_->deletions_pending) return ids;
  Statement rows(impl_->database, "SELECT id FROM job WHERE deleted=1");
  while (rows.step()) ids.push_back(rows.text());
  if (auto status = rows.status(); !status.ok()) return status;
  impl_->deletions_pending = !ids.empty();
  return ids;
}

absl::Status JobStore::forget_requests_before(Moment moment) {
  const std::lock_guard lock(impl_->mutex);
  return impl_->with_reserve(
      [&] { return Statement(impl_->database, "DELETE FROM request WHERE moment<?").bind(moment).run(); });
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
