// Starts, follows and stops workers: one thread that owns every child of the daemon.
//
//   each turn: ended workers -> what they brought forth -> what was asked of running jobs -> stalls -> room
//   -> next job
//
// Intent is in the store: pause, cancel and submit write there and wake the supervisor, which does what
// stands there. So a daemon that was killed in between does it after its restart.
#pragma once

#include <atomic>
#include <chrono>
#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <thread>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/folder/file_descriptor.h"
#include "server/execution/worker_process.h"
#include "server/folders/sample_index.h"
#include "server/rules/attempt_ending.h"
#include "server/store/job_store.h"

namespace creepd {

struct SupervisorOptions {
  std::filesystem::path jobs;    ///< folder of the job folders
  std::filesystem::path worker;  ///< program
  int slots = 1;
  int threads_per_job = 1;
  double checkpoint_interval = 30.0;  ///< [s]
  std::uint64_t memory_limit = 0;     ///< for the sum of the estimates of running jobs [bytes]
  double stall_limit = 600.0;         ///< [s] without progress, then the worker is killed
  double stop_limit = 150.0;          ///< [s] for a worker's last checkpoint
  /// Told the number of running jobs after each turn, at least every second, by the supervisor's thread.
  std::function<void(int running)> turned;
};

class Supervisor {
 public:
  Supervisor(SupervisorOptions options, JobStore& store, SampleLibrary& samples);
  ~Supervisor();

  /// Brings every job into a state that is true: waits for workers of a daemon that is gone, takes over their
  /// verdicts, finishes deletions. Before anybody else uses the store.
  absl::Status recover();

  void start();
  /// Something was asked. Any thread.
  void wake() const;
  /// Has all workers checkpoint, gives their attempts back and ends the thread. `quick`, set from any thread
  /// meanwhile, kills them instead.
  void stop();
  void hurry();

  int running() const { return running_count_; }

 private:
  using Clock = std::chrono::steady_clock;

  struct Running {
    std::filesystem::path folder;
    std::int64_t attempt = 0;
    std::optional<WorkerProcess> process;  ///< nothing if it could not be started; then there is an end
    std::shared_ptr<SampleIndex> samples;
    std::uint64_t memory = 0;
    std::uint64_t told = 0;
    std::int64_t progress_changed = 0;   ///< modification of progress.json [ns]
    std::uint64_t kills_for_memory = 0;  ///< of the machine, when it started
    Clock::time_point last_progress;
    std::optional<Clock::time_point> asked_to_stop;
    bool killed = false;
    bool stalled = false;
    bool said_not_stored = false;
    std::optional<AttemptEnd> end;  ///< looked at once: the disk that was full may have room later
  };
  void loop();
  void wait_for_news();
  void reap();
  bool record_end(const std::string& id, Running& running);
  AttemptEnd end_of(const Running& running, const ProcessEnd& process) const;
  void follow();
  void obey_requests();
  void check_limits();
  void look_at_storage();
  void resume_where_room();
  void start_next();
  void start_attempt(const Job& job);
  void start_process(const Job& job, Running& running);
  void ask_to_stop(Running& running, bool now);
  absl::Status recover_running(const Job& job);
  absl::Status tell_all(const std::string& id, const std::filesystem::path& folder, SampleIndex& samples);
  absl::Status finish_deletions();
  void remove_stray_folders();

  SupervisorOptions options_;
  JobStore& store_;
  SampleLibrary& samples_;
  creep::FileDescriptor wake_;
  std::map<std::string, Running> running_;
  std::atomic<int> running_count_ = 0;
  std::atomic<bool> stopping_ = false;
  std::atomic<bool> hurry_ = false;
  Clock::time_point followed_{};
  Clock::time_point looked_at_storage_{};
  std::thread thread_;
};

}  // namespace creepd
