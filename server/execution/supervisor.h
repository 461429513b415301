// Decides which job is computed when, when an attempt is to stop, and what its end means: one thread.
//
//   each turn: news of attempts -> what they brought forth -> what was asked of running jobs -> limits
//   -> upkeep -> next job
//
// Intent is in the store: pause, cancel and submit write there and wake the supervisor, which does what
// stands there. So a daemon that was killed in between does it after its restart. How an attempt is started,
// stopped and observed is the executor's.
#pragma once

#include <atomic>
#include <chrono>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <thread>

#include "absl/status/status.h"
#include "core/folder/file_descriptor.h"
#include "server/execution/executor.h"
#include "server/execution/upkeep.h"
#include "server/folders/sample_index.h"
#include "server/rules/attempt_ending.h"
#include "server/store/job_store.h"

namespace creepd {

struct SupervisorOptions {
  std::filesystem::path jobs;  ///< folder of the job folders
  int threads_per_job = 1;
  double checkpoint_interval = 30.0;  ///< [s]
  double stall_limit = 600.0;         ///< [s] without progress, then the worker is killed
  double stop_limit = 150.0;          ///< [s] for a worker's last checkpoint
  /// Told the number of running jobs after each turn, at least every second, by the supervisor's thread.
  std::function<void(int running)> turned;
};

class Supervisor {
 public:
  Supervisor(SupervisorOptions options, JobStore& store, SampleLibrary& samples, Executor& executor);
  ~Supervisor();

  /// Takes over the attempts of a daemon that is gone and what it left undone; those that are over come into
  /// a true state at once. Before anybody else uses the store.
  absl::Status recover();

  /// Turns, in a thread of its own.
  void start();
  /// Something was asked. Any thread.
  void wake() const;
  /// Ends the thread; attempts that would not go on without the daemon checkpoint first and are given back.
  /// `hurry`, called from any thread meanwhile, has them killed instead.
  void stop();
  void hurry();

  /// One turn, beginning with a wait for news of at most a second.
  void turn();

 private:
  using Clock = std::chrono::steady_clock;

  struct Running {
    AttemptKey key;
    std::filesystem::path folder;
    Attempt attempt;  ///< as stored
    Phase phase = Phase::kUnknown;
    bool adopted = false;
    std::shared_ptr<SampleIndex> samples;
    std::uint64_t told = 0;
    std::int64_t progress_mark = 0;
    Clock::time_point last_progress = Clock::now();
    std::optional<Clock::time_point> asked_to_stop;
    bool killed = false;
    bool stalled = false;
    bool said_waiting = false;
    bool said_not_stored = false;
    std::optional<AttemptEnd> end;  ///< looked at once: the disk that was full may have room later
  };

  void wait_for_news();
  void take_news();
  void heed(Running& running, const AttemptNews& news);
  void heed_life(Running& running, const AttemptNews& news);
  void heed_end(Running& running, const AttemptNews& news);
  void say_waiting(Running& running);
  void reap();
  bool record_end(Running& running);
  bool is_left_behind(const Running& running) const;
  absl::Status tell_all(const Running& running);
  void follow();
  void obey_requests();
  void ask_to_stop(Running& running, StopMode mode);
  void check_limits();
  void start_next();
  /// False if it has failed already.
  bool start_attempt(const Job& queued);
  void carry_out(const Job& job, Running& running);
  void adopt(const Job& job);

  SupervisorOptions options_;
  JobStore& store_;
  SampleLibrary& samples_;
  Executor& executor_;
  Upkeep upkeep_;
  creep::FileDescriptor wake_;
  std::map<std::string, Running> running_;  ///< by job
  std::atomic<bool> stopping_ = false;
  std::atomic<bool> hurry_ = false;
  Clock::time_point followed_{};
  std::thread thread_;
};

}  // namespace creepd
