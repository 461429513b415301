#include "server/execution/supervisor.h"

#include <poll.h>
#include <signal.h>
#include <sys/eventfd.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <system_error>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "core/folder/durable_file.h"
#include "core/folder/job_directory.h"
#include "server/folders/job_files.h"
#include "server/host/daemon_log.h"
#include "server/host/wall_clock.h"

namespace creepd {
namespace {

namespace fs = std::filesystem;
using std::chrono::duration;
using std::chrono::milliseconds;

constexpr milliseconds kTurn{200};          // while something runs
constexpr milliseconds kIdleTurn{1000};     // back-offs end within it
constexpr milliseconds kTelling{500};       // between two records of progress in the store
constexpr milliseconds kStorageLook{2000};  // between two looks for room and for deletions that failed

/// Processes that the kernel has killed for memory since the machine started.
std::uint64_t kills_for_memory() {
  std::ifstream statistics("/proc/vmstat");
  std::string name;
  std::uint64_t value = 0;
  while (statistics >> name >> value) {
    if (name == "oom_kill") return value;
  }
  return 0;
}

std::int64_t modification(const fs::path& path) {
  struct stat about {};
  if (::stat(path.c_str(), &about) != 0) return 0;
  return about.st_mtim.tv_sec * 1'000'000'000 + about.st_mtim.tv_nsec;
}

std::string progress_text(const fs::path& folder) {
  const auto text = creep::read_file(creep::JobDirectory(folder).progress(), 1 << 16);
  return text.ok() ? *text : std::string();
}

/// Whether the file system has room for an attempt. Its folder need not be there: a power cut may have taken
/// it, and the attempt makes it anew.
bool has_room(const fs::path& folder) { return free_bytes(folder.parent_path()) >= needed_bytes(folder); }

/// What a job folder says about an attempt that has ended.
AttemptEnd look_at(const fs::path& folder, std::int64_t attempt) {
  AttemptEnd end;
  if (verdict_attempt(folder) == attempt)
    end.verdict = creep::read_verdict(creep::JobDirectory(folder).verdict());
  end.disk_full = !has_room(folder);
  end.checkpoint = newest_checkpoint(folder);
  end.state_digest = state_digest(folder);
  end.log_tail = log_tail(folder);
  return end;
}

absl::StatusOr<JobStore::Telling> news_of(const std::string& id, const fs::path& folder,
                                          SampleIndex& samples) {
  const auto count = samples.poll();
  if (!count.ok()) return count.status();
  JobStore::Telling news{id, *count, {}, progress_text(folder)};
  if (*count > 0) {
    const auto latest = samples.read(*count - 1);
    if (!latest.ok()) return latest.status();
    news.latest_sample = creep::encode(*latest);
  }
  return news;
}

}  // namespace

Supervisor::Supervisor(SupervisorOptions options, JobStore& store, SampleLibrary& samples)
    : options_(std::move(options)),
      store_(store),
      samples_(samples),
      wake_(::eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC)) {}

Supervisor::~Supervisor() { stop(); }

void Supervisor::start() {
  thread_ = std::thread([this] { loop(); });
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

void Supervisor::loop() {
  while (!stopping_ || !running_.empty()) {
    wait_for_news();
    reap();
    follow();
    obey_requests();
    check_limits();
    if (!stopping_) {
      look_at_storage();
      start_next();
    }
    running_count_ = static_cast<int>(running_.size());
    if (options_.turned) options_.turned(running_count_);
  }
}

void Supervisor::wait_for_news() {
  std::vector<pollfd> news{{wake_.get(), POLLIN, 0}};
  bool waiting_for_store = false;
  for (const auto& [id, running] : running_) {
    if (running.end) {
      waiting_for_store = true;
    } else {
      news.push_back({running.process->descriptor(), POLLIN, 0});
    }
  }
  const auto turn = running_.empty() ? kIdleTurn : kTurn;
  ::poll(news.data(), news.size(), static_cast<int>(turn.count()));
  if (waiting_for_store) ::poll(nullptr, 0, static_cast<int>(kTurn.count()));
  std::uint64_t count = 0;
  if (::read(wake_.get(), &count, sizeof count) < 0) return;  // nobody woke it
}

void Supervisor::reap() {
  for (auto entry = running_.begin(); entry != running_.end();) {
    Running& running = entry->second;
    if (!running.end) {
      if (const auto process = running.process->poll()) running.end = end_of(running, *process);
    }
    // An end that cannot be stored now is stored in a later turn. A daemon that is to stop does not wait for
    // that: it would be killed, and the next one finds out by itself, as after a kill.
    if (running.end && (record_end(entry->first, running) || stopping_)) {
      entry = running_.erase(entry);
    } else {
      ++entry;
    }
  }
}

bool Supervisor::record_end(const std::string& id, Running& running) {
  // Its last samples are told first, so that the final state is the last event.
  const auto told = tell_all(id, running.folder, *running.samples);
  const auto store = [&]() -> absl::StatusOr<Job> {
    if (absl::IsUnavailable(told)) return told;
    return store_.change(id, [&](Job& row) {
      conclude(row, *running.end, wall_clock());
      return absl::OkStatus();
    });
  };
  const auto job = store();
  if (!job.ok()) {
    if (!std::exchange(running.said_not_stored, true)) {
      log_line(
          absl::StrCat("job ", id, ": its end cannot be stored yet: ", std::string(job.status().message())));
    }
    return false;
  }
  log_line(absl::StrCat("job ", id, " attempt ", job->lease_attempt, " ended: ", state_name(job->state), ": ",
                        job->message));
  return true;
}

AttemptEnd Supervisor::end_of(const Running& running, const ProcessEnd& process) const {
  AttemptEnd end = look_at(running.folder, running.attempt);
  end.exit_code = process.exit_code;
  end.signal = process.signal;
  end.stalled = running.stalled;
  end.daemon_stopped = stopping_;
  end.out_of_memory =
      end.signal == SIGKILL && !running.killed && kills_for_memory() > running.kills_for_memory;
  if (end.verdict && end.verdict->exit_code != end.exit_code) end.verdict.reset();
  return end;
}

absl::Status Supervisor::tell_all(const std::string& id, const fs::path& folder, SampleIndex& samples) {
  const auto news = news_of(id, folder, samples);
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
    const std::int64_t changed = modification(creep::JobDirectory(running.folder).progress());
    const auto samples = running.samples->poll();
    if (!samples.ok() || (changed == running.progress_changed && *samples == running.told)) continue;
    running.progress_changed = changed;
    running.last_progress = Clock::now();
    auto news = news_of(id, running.folder, *running.samples);
    if (!news.ok()) continue;
    all.push_back(*std::move(news));
    told.push_back(&running);
  }
  if (all.empty() || !store_.tell(all).ok()) return;
  for (std::size_t i = 0; i < all.size(); ++i) told[i]->told = all[i].samples;
}

void Supervisor::ask_to_stop(Running& running, bool at_once) {
  if (running.end) return;
  if (at_once && !running.killed) {
    running.killed = true;
    running.process->send(SIGKILL);
  } else if (!running.asked_to_stop) {
    running.asked_to_stop = Clock::now();
    running.process->send(SIGTERM);
  }
}

void Supervisor::obey_requests() {
  if (running_.empty()) return;
  if (stopping_) {
    for (auto& [id, running] : running_) ask_to_stop(running, hurry_);
    return;
  }
  const auto jobs = store_.running();
  if (!jobs.ok()) return;
  for (const Job& job : *jobs) {
    const auto entry = running_.find(job.id);
    if (entry == running_.end()) continue;
    if (job.reason == StateReason::kPauseRequested) ask_to_stop(entry->second, false);
    if (job.reason == StateReason::kCancelRequested) ask_to_stop(entry->second, job.stop_now);
  }
}

void Supervisor::check_limits() {
  for (auto& [id, running] : running_) {
    if (running.end || running.killed) continue;
    if (running.asked_to_stop &&
        duration<double>(Clock::now() - *running.asked_to_stop).count() > options_.stop_limit) {
      log_line(absl::StrCat("job ", id, ": its worker does not stop and is killed"));
      ask_to_stop(running, true);
    } else if (duration<double>(Clock::now() - running.last_progress).count() > options_.stall_limit) {
      log_line(
          absl::StrCat("job ", id, ": no progress for ", options_.stall_limit, " s, its worker is killed"));
      running.stalled = true;
      ask_to_stop(running, true);
    }
  }
}

void Supervisor::look_at_storage() {
  if (Clock::now() - looked_at_storage_ < kStorageLook) return;
  looked_at_storage_ = Clock::now();
  resume_where_room();
  if (auto status = finish_deletions(); !status.ok()) return;  // tried again at the next look
}

void Supervisor::resume_where_room() {
  if (!store_.restore_reserve()) return;
  const auto paused = store_.paused(StateReason::kDiskFull);
  if (!paused.ok()) return;
  for (const Job& job : *paused) {
    if (job.not_before > wall_clock() || !has_room(options_.jobs / job.id)) continue;
    const auto resumed = store_.change(job.id, [](Job& row) {
      if (row.state != JobState::kPaused || row.reason != StateReason::kDiskFull) return absl::OkStatus();
      row.state = JobState::kQueued;
      row.reason = StateReason::kResumed;
      row.message = "there is room again";
      return absl::OkStatus();
    });
    if (resumed.ok()) log_line(absl::StrCat("job ", job.id, ": there is room again, it goes on"));
  }
}

void Supervisor::start_next() {
  while (static_cast<int>(running_.size()) < options_.slots) {
    const auto next = store_.next_queued(wall_clock());
    if (!next.ok() || !*next) return;
    std::uint64_t memory = (*next)->memory_estimate;
    for (const auto& [id, running] : running_) memory += running.memory;
    if (memory > options_.memory_limit && !running_.empty()) return;
    // On a full disk it would soon fail, and use up the reserve that its end needs.
    if (!store_.restore_reserve() || !has_room(options_.jobs / (*next)->id)) return;
    start_attempt(**next);
  }
}

void Supervisor::start_attempt(const Job& queued) {
  const fs::path folder = options_.jobs / queued.id;
  // Counted and durable first: a job that takes the machine down with it is counted too.
  const auto job = store_.change(queued.id, [&](Job& row) {
    if (row.state != JobState::kQueued) return absl::AbortedError("no longer queued");
    row.state = JobState::kRunning;
    row.reason = StateReason::kNone;
    row.message.clear();
    ++row.attempts;
    row.lease_attempt = std::max(row.lease_attempt, lease_attempt(folder).value_or(0)) + 1;
    row.checkpoint = std::max(row.checkpoint, newest_checkpoint(folder));
    if (!row.started) row.started = wall_clock();
    return absl::OkStatus();
  });
  if (!job.ok()) return;
  Running running{.folder = folder,
                  .attempt = job->lease_attempt,
                  .process = std::nullopt,
                  .samples = samples_.of(job->id),
                  .memory = job->memory_estimate,
                  .told = job->samples,
                  .progress_changed = 0,
                  .kills_for_memory = kills_for_memory(),
                  .last_progress = Clock::now(),
                  .asked_to_stop = std::nullopt,
                  .killed = false,
                  .stalled = false,
                  .said_not_stored = false,
                  .end = std::nullopt};
  start_process(*job, running);
  running_.emplace(job->id, std::move(running));
}

void Supervisor::start_process(const Job& job, Running& running) {
  // Once a job, and again where a power cut took it: a lease means that a worker found it well.
  if (!lease_attempt(running.folder)) {
    if (auto status = secure_job_folder(running.folder, job.spec); !status.ok()) {
      running.end = look_at(running.folder, running.attempt);
      running.end->exit_code = creep::kIoError;
      running.end->verdict = creep::Ending{creep::kIoError, "io_error", std::string(status.message()), ""};
      return;
    }
  }
  auto process = WorkerProcess::start({options_.worker, running.folder, running.attempt,
                                       options_.threads_per_job, options_.checkpoint_interval});
  if (!process.ok()) {
    log_line(absl::StrCat("job ", job.id, ": ", std::string(process.status().message())));
    running.end = look_at(running.folder, running.attempt);
    running.end->never_started = true;
    return;
  }
  log_line(absl::StrCat("job ", job.id, " attempt ", running.attempt, " started, process ", process->id()));
  running.process = *std::move(process);
}

absl::Status Supervisor::recover() {
  if (auto status = finish_deletions(); !status.ok()) return status;
  remove_stray_folders();
  const auto jobs = store_.running();
  if (!jobs.ok()) return jobs.status();
  for (const Job& job : *jobs) {
    if (auto status = recover_running(job); !status.ok()) return status;
  }
  constexpr Moment kDay = std::int64_t{86400} * 1'000'000;
  return store_.forget_requests_before(wall_clock() - 30 * kDay);
}

absl::Status Supervisor::finish_deletions() {
  const auto deleted = store_.marked_deleted();
  if (!deleted.ok()) return deleted.status();
  for (const std::string& id : *deleted) {
    std::error_code error;
    fs::remove_all(options_.jobs / id, error);
    if (error || !creep::sync_directory(options_.jobs).ok()) continue;
    if (auto status = store_.forget(id); !status.ok()) return status;
  }
  return absl::OkStatus();
}

absl::Status Supervisor::recover_running(const Job& job) {
  const fs::path folder = options_.jobs / job.id;
  // The worker of the daemon that is gone has read the end of its pipe and is writing its checkpoint.
  const auto give_up = Clock::now() + duration<double>(options_.stop_limit);
  bool said = false;
  while (lease_is_held(folder)) {
    if (!std::exchange(said, true)) log_line(absl::StrCat("job ", job.id, ": waits for its former worker"));
    if (Clock::now() > give_up) {
      return absl::UnavailableError(absl::StrCat("the former worker of job ", job.id,
                                                 " does not end; its process is named in ",
                                                 creep::JobDirectory(folder).lease().string()));
    }
    ::poll(nullptr, 0, 50);
  }
  if (auto told = tell_all(job.id, folder, *samples_.of(job.id)); absl::IsUnavailable(told)) return told;
  const auto recovered = store_.change(job.id, [&](Job& row) {
    AttemptEnd end = look_at(folder, row.lease_attempt);
    if (end.verdict) end.exit_code = end.verdict->exit_code;
    end.daemon_stopped = true;
    conclude(row, end, wall_clock());
    return absl::OkStatus();
  });
  if (!recovered.ok()) return recovered.status();
  log_line(absl::StrCat("job ", job.id, " was running when creepd went down: ", state_name(recovered->state),
                        ": ", recovered->message));
  return absl::OkStatus();
}

void Supervisor::remove_stray_folders() {
  std::error_code error;
  for (fs::directory_iterator entry(options_.jobs, error), end; !error && entry != end;
       entry.increment(error)) {
    const std::string id = entry->path().filename().string();
    if (!absl::IsNotFound(store_.get(id).status())) continue;
    // Only what was never acknowledged goes by itself: a folder in which no worker has been.
    if (fs::exists(creep::JobDirectory(entry->path()).lease(), error)) {
      log_line(absl::StrCat(entry->path().string(), " belongs to no job and is left alone"));
    } else {
      fs::remove_all(entry->path(), error);
    }
  }
}

}  // namespace creepd
