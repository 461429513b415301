#include "server/execution/supervisor.h"

#include <poll.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <algorithm>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "server/execution/attempt_files.h"
#include "server/folders/job_files.h"
#include "server/host/daemon_log.h"
#include "server/host/wall_clock.h"

namespace creepd {
namespace {

using std::chrono::duration;
using std::chrono::milliseconds;

constexpr milliseconds kTurn{200};       // while something runs
constexpr milliseconds kIdleTurn{1000};  // back-offs end within it
constexpr milliseconds kTelling{500};    // between two records of progress in the store

double seconds_since(std::chrono::steady_clock::time_point moment) {
  return duration<double>(std::chrono::steady_clock::now() - moment).count();
}

}  // namespace

Supervisor::Supervisor(SupervisorOptions options, JobStore& store, SampleLibrary& samples, Executor& executor)
    : options_(std::move(options)),
      store_(store),
      samples_(samples),
      executor_(executor),
      upkeep_(options_.jobs, store),
      wake_(::eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC)) {}

Supervisor::~Supervisor() { stop(); }

void Supervisor::start() {
  thread_ = std::thread([this] {
    while (!stopping_ || !running_.empty()) turn();
  });
}

void Supervisor::wake() const {
  const std::uint64_t one = 1;
  if (::write(wake_.get(), &one, sizeof one) < 0) return;  // full: it is awake already
}

void Supervisor::stop() {
  stopping_ = true;
  wake();
  if (thread_.joinable()) thread_.join();
}

void Supervisor::hurry() {
  hurry_ = true;
  wake();
}

void Supervisor::turn() {
  wait_for_news();
  take_news();
  reap();
  follow();
  obey_requests();
  check_limits();
  if (!stopping_) {
    upkeep_.turn();
    start_next();
  }
  if (options_.turned) options_.turned(static_cast<int>(running_.size()));
}

void Supervisor::wait_for_news() {
  pollfd news[] = {{wake_.get(), POLLIN, 0}, {executor_.descriptor(), POLLIN, 0}};
  ::poll(news, 2, static_cast<int>((running_.empty() ? kIdleTurn : kTurn).count()));
  const auto waits_for_store = [](const auto& entry) { return entry.second.end.has_value(); };
  if (std::any_of(running_.begin(), running_.end(), waits_for_store))
    ::poll(nullptr, 0, static_cast<int>(kTurn.count()));
  std::uint64_t count = 0;
  if (::read(wake_.get(), &count, sizeof count) < 0) return;  // nobody woke it
}

void Supervisor::take_news() {
  for (const AttemptNews& news : executor_.news()) {
    const auto found = running_.find(news.key.job);
    if (found != running_.end() && found->second.key == news.key) {
      heed(found->second, news);
    } else if (news.phase == Phase::kEnded) {
      executor_.forget(news.key);  // an old story: its end is stored, or its job is gone
    }
  }
}

void Supervisor::heed(Running& running, const AttemptNews& news) {
  if (running.end) return;
  switch (news.phase) {
    case Phase::kUnknown:
      running.last_progress = Clock::now();  // silence is not a stall
      return;
    case Phase::kWaiting:
    case Phase::kRunning:
      return heed_life(running, news);
    case Phase::kEnded:
      return heed_end(running, news);
  }
}

void Supervisor::heed_life(Running& running, const AttemptNews& news) {
  if (running.phase != news.phase) running.last_progress = Clock::now();
  running.phase = news.phase;
  Attempt now = running.attempt;
  now.state = news.phase == Phase::kRunning ? AttemptState::kRunning : AttemptState::kWaiting;
  now.engine_id = news.engine_id;
  now.place = news.place;
  now.words = news.words;
  const bool begins = news.phase == Phase::kRunning && !now.started;
  if (begins) now.started = wall_clock();
  const Attempt& before = running.attempt;
  if (now.state == before.state && now.engine_id == before.engine_id && now.place == before.place &&
      now.words == before.words) {
    return;
  }
  if (begins) {
    log_line(absl::StrCat("job ", running.key.job, " attempt ", running.key.number, " started, ", now.place));
  }
  // Where this fails the end of the attempt tells it too.
  store_.note(running.key.job, now).IgnoreError();
  running.attempt = std::move(now);
}

void Supervisor::heed_end(Running& running, const AttemptNews& news) {
  running.phase = Phase::kEnded;
  const bool held =
      lease_is_held(running.folder);  // first: a verdict is written before the lease is given up
  if (!is_over(verdict_of(running.folder, running.key.number), held)) return say_waiting(running);
  AttemptEnd end = end_in_folder(running.folder, running.key.number);
  end.process = news.process.value_or(ProcessEnd{});
  end.cause = news.cause;
  end.stalled = running.stalled;
  end.daemon_stopped = stopping_ || (running.adopted && !executor_.survives_daemon());
  if (!news.process && end.cause == Cause::kNone && lease_attempt(running.folder) != running.key.number)
    end.cause = Cause::kNeverRan;
  running.attempt.engine_id = news.engine_id.empty() ? running.attempt.engine_id : news.engine_id;
  running.attempt.place = news.place.empty() ? running.attempt.place : news.place;
  running.end = std::move(end);
}

void Supervisor::say_waiting(Running& running) {
  if (std::exchange(running.said_waiting, true)) return;
  log_line(absl::StrCat("job ", running.key.job, ": waits for its former worker"));
  const auto said = store_.change(running.key.job, [&running](Job& row) {
    if (row.state != JobState::kRunning) return absl::OkStatus();
    row.message = absl::StrCat("waits for its former worker, ", lease_holder(running.folder),
                               ", which still holds the job folder; goes on by itself when that ends");
    return absl::OkStatus();
  });
  if (!said.ok()) running.said_waiting = false;
}

bool Supervisor::is_left_behind(const Running& running) const {
  return executor_.survives_daemon() || running.phase == Phase::kEnded || running.phase == Phase::kUnknown;
}

void Supervisor::reap() {
  for (auto entry = running_.begin(); entry != running_.end();) {
    Running& running = entry->second;
    // An end that cannot be stored now is stored in a later turn. A daemon that is to stop does not wait for
    // that: it would be killed, and the next one finds out by itself, as after a kill.
    const bool done = running.end && record_end(running);
    if (done) executor_.forget(running.key);
    if (done || (stopping_ && (running.end || is_left_behind(running)))) {
      entry = running_.erase(entry);
    } else {
      ++entry;
    }
  }
}

bool Supervisor::record_end(Running& running) {
  // Its last samples are told first, so that the final state is the last event.
  const auto told = tell_all(running);
  Attempt ended = running.attempt;
  const auto store = [&]() -> absl::StatusOr<Job> {
    if (absl::IsUnavailable(told)) return told;
    return store_.change(
        running.key.job,
        [&](Job& row) {
          conclude(row, *running.end, wall_clock());
          ended.words = row.message;
          return absl::OkStatus();
        },
        &ended);
  };
  ended.state = AttemptState::kEnded;
  ended.ended = wall_clock();
  ended.process.exit_code = exit_code_of(*running.end);
  ended.process.signal = running.end->process.signal;
  ended.cause = running.end->cause;
  const auto job = store();
  if (!job.ok()) {
    if (!std::exchange(running.said_not_stored, true)) {
      log_line(absl::StrCat("job ", running.key.job,
                            ": its end cannot be stored yet: ", std::string(job.status().message())));
    }
    return false;
  }
  log_line(absl::StrCat("job ", running.key.job, " attempt ", running.key.number,
                        " ended: ", state_name(job->state), ": ", job->message));
  return true;
}

absl::Status Supervisor::tell_all(const Running& running) {
  const auto news = progress_in_folder(running.key.job, running.folder, *running.samples);
  if (!news.ok()) return news.status();
  auto told = store_.tell({*news});
  if (absl::IsUnavailable(told) && store_.use_reserve()) told = store_.tell({*news});
  return told;
}

void Supervisor::follow() {
  if (Clock::now() - followed_ < kTelling) return;
  followed_ = Clock::now();
  std::vector<JobStore::Telling> all;
  std::vector<Running*> told;
  for (auto& [id, running] : running_) {
    const std::int64_t mark = progress_mark(running.folder);
    const auto samples = running.samples->poll();
    if (!samples.ok() || (mark == running.progress_mark && *samples == running.told)) continue;
    running.progress_mark = mark;
    running.last_progress = Clock::now();
    auto news = progress_in_folder(id, running.folder, *running.samples);
    if (!news.ok()) continue;
    all.push_back(*std::move(news));
    told.push_back(&running);
  }
  if (all.empty() || !store_.tell(all).ok()) return;
  for (std::size_t i = 0; i < all.size(); ++i) told[i]->told = all[i].samples;
}

void Supervisor::obey_requests() {
  if (running_.empty()) return;
  if (stopping_) {
    for (auto& [id, running] : running_) {
      if (!is_left_behind(running)) ask_to_stop(running, hurry_ ? StopMode::kNow : StopMode::kCheckpoint);
    }
    return;
  }
  const auto jobs = store_.running();
  if (!jobs.ok()) return;
  for (const Job& job : *jobs) {
    const auto entry = running_.find(job.id);
    if (entry == running_.end()) continue;
    if (job.reason == StateReason::kPauseRequested) ask_to_stop(entry->second, StopMode::kCheckpoint);
    if (job.reason == StateReason::kCancelRequested)
      ask_to_stop(entry->second, job.stop_now ? StopMode::kNow : StopMode::kCheckpoint);
  }
}

void Supervisor::ask_to_stop(Running& running, StopMode mode) {
  if (running.end || running.phase == Phase::kEnded) return;
  if (mode == StopMode::kNow && !running.killed) {
    running.killed = true;
    executor_.stop(running.key, mode);
  } else if (!running.asked_to_stop) {
    running.asked_to_stop = Clock::now();
    executor_.stop(running.key, mode);
  }
}

void Supervisor::check_limits() {
  for (auto& [id, running] : running_) {
    if (running.end || running.killed || running.phase != Phase::kRunning) continue;
    if (running.asked_to_stop && seconds_since(*running.asked_to_stop) > options_.stop_limit) {
      log_line(absl::StrCat("job ", id, ": its worker does not stop and is killed"));
      ask_to_stop(running, StopMode::kNow);
    } else if (seconds_since(running.last_progress) > options_.stall_limit) {
      log_line(
          absl::StrCat("job ", id, ": no progress for ", options_.stall_limit, " s, its worker is killed"));
      running.stalled = true;
      ask_to_stop(running, StopMode::kNow);
    }
  }
}

void Supervisor::start_next() {
  bool started = false;
  for (;;) {
    const auto next = store_.next_queued(wall_clock());
    if (!next.ok() || !*next || !executor_.has_room((*next)->memory_estimate)) break;
    // On a full disk it would soon fail, and use up the reserve that its end needs.
    if (!store_.restore_reserve() || !has_room_for_attempt(options_.jobs / (*next)->id)) break;
    if (!start_attempt(**next)) break;
    started = true;
  }
  if (started) take_news();
}

bool Supervisor::start_attempt(const Job& queued) {
  const std::filesystem::path folder = options_.jobs / queued.id;
  Attempt attempt;
  attempt.engine = executor_.engine();
  attempt.asked = wall_clock();
  // Counted and durable first: a job that takes the machine down with it is counted too.
  const auto job = store_.change(
      queued.id,
      [&](Job& row) {
        if (row.state != JobState::kQueued) return absl::AbortedError("no longer queued");
        row.state = JobState::kRunning;
        row.reason = StateReason::kNone;
        row.message.clear();
        ++row.attempts;
        row.lease_attempt = std::max(row.lease_attempt, lease_attempt(folder).value_or(0)) + 1;
        row.checkpoint = std::max(row.checkpoint, newest_checkpoint(folder));
        if (!row.started) row.started = wall_clock();
        attempt.number = row.lease_attempt;
        return absl::OkStatus();
      },
      &attempt);
  if (!job.ok()) return false;
  Running running;
  running.key = {job->id, job->lease_attempt};
  running.folder = folder;
  running.attempt = attempt;
  running.samples = samples_.of(job->id);
  running.told = job->samples;
  carry_out(*job, running);
  return !running_.emplace(job->id, std::move(running)).first->second.end;
}

void Supervisor::carry_out(const Job& job, Running& running) {
  // Once a job, and again where a power cut took it: a lease means that a worker found it well.
  if (!lease_attempt(running.folder)) {
    if (auto status = secure_job_folder(running.folder, job.spec); !status.ok()) {
      running.end = end_in_folder(running.folder, running.key.number);
      running.end->verdict = creep::Ending{creep::kIoError, "io_error", std::string(status.message()), ""};
      return;
    }
  }
  const auto started = executor_.start({running.key, running.folder, options_.threads_per_job,
                                        job.memory_estimate, options_.checkpoint_interval});
  if (started.ok()) {
    running.phase = Phase::kWaiting;
    return;
  }
  log_line(absl::StrCat("job ", job.id, ": ", std::string(started.message())));
  if (absl::IsUnavailable(started)) return;  // perhaps it has it: news will tell
  running.end = end_in_folder(running.folder, running.key.number);
  running.end->cause = Cause::kNeverRan;
}

absl::Status Supervisor::recover() {
  if (auto status = upkeep_.begin(); !status.ok()) return status;
  const auto jobs = store_.running();
  if (!jobs.ok()) return jobs.status();
  std::vector<AttemptKey> keys;
  for (const Job& job : *jobs) {
    adopt(job);
    keys.push_back({job.id, job.lease_attempt});
  }
  executor_.adopt(keys);
  take_news();
  reap();
  return absl::OkStatus();
}

void Supervisor::adopt(const Job& job) {
  Running running;
  running.key = {job.id, job.lease_attempt};
  running.folder = options_.jobs / job.id;
  running.adopted = true;
  running.samples = samples_.of(job.id);
  running.told = job.samples;
  const auto stored = store_.attempts(job.id, job.lease_attempt, 1);
  if (stored.ok() && !stored->empty() && stored->front().number == job.lease_attempt) {
    running.attempt = stored->front();
  } else {
    running.attempt.number = job.lease_attempt;
    running.attempt.engine = executor_.engine();
    running.attempt.asked = job.started.value_or(job.submitted);
  }
  log_line(absl::StrCat("job ", job.id, " was running when creepd went down"));
  running_.emplace(job.id, std::move(running));
}

}  // namespace creepd
