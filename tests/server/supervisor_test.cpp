// The real supervisor and a real store, with an executor that says what a test makes it say: what a batch
// system does only once in a while. The rows of the table are those of attempt_ending.h and executor.h.
#include "server/execution/supervisor.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/eventfd.h>
#include <sys/file.h>
#include <unistd.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <functional>
#include <memory>
#include <thread>

#include "core/folder/durable_file.h"
#include "core/folder/ending.h"
#include "core/folder/job_directory.h"
#include "server/host/wall_clock.h"
#include "server/jobs/jobs.h"
#include "tests/server/temporary_directory.h"

namespace creepd {
namespace {

constexpr const char* kSpec =
    "[specimen]\nparticles = 30\nvoid_ratio = 0.8\n[[program]]\nstage = \"oedometric\"\n"
    "until = { axial_stress = \"1 MPa\" }\n";
const Caller kAlice{"uid:1001", false};

class ScriptedExecutor final : public Executor {
 public:
  ScriptedExecutor() : readable_(::eventfd(1, EFD_CLOEXEC)) {}

  // The script.
  int slots = 1;
  bool survives = false;
  absl::Status answer;
  std::function<void(const AttemptOrder&)> at_start;
  std::vector<AttemptNews> says;

  // What was asked of it.
  std::vector<AttemptOrder> started;
  std::vector<std::pair<AttemptKey, StopMode>> stopped;
  std::vector<AttemptKey> adopted;
  std::vector<AttemptKey> forgotten;

  std::string engine() const override { return "scripted"; }
  bool has_room(std::uint64_t) const override { return static_cast<int>(says.size()) < slots; }
  absl::Status start(const AttemptOrder& order) override {
    if (at_start) at_start(order);
    started.push_back(order);
    if (answer.ok()) say(order.key, Phase::kWaiting);
    return answer;
  }
  void stop(const AttemptKey& key, StopMode mode) override { stopped.emplace_back(key, mode); }
  std::vector<AttemptNews> news() override { return says; }
  void forget(const AttemptKey& key) override {
    forgotten.push_back(key);
    std::erase_if(says, [&](const AttemptNews& news) { return news.key == key; });
  }
  void adopt(const std::vector<AttemptKey>& keys) override {
    adopted = keys;
    if (survives) return;
    for (const AttemptKey& key : keys) say(key, Phase::kEnded);
  }
  bool survives_daemon() const override { return survives; }
  int descriptor() const override { return readable_.get(); }  // always: no turn waits

  void say(const AttemptKey& key, Phase phase, Cause cause = Cause::kNone,
           std::optional<ProcessEnd> process = std::nullopt) {
    std::erase_if(says, [&](const AttemptNews& news) { return news.key == key; });
    says.push_back({key, phase, cause, process, "4711", phase == Phase::kWaiting ? "" : "n7", ""});
  }

 private:
  creep::FileDescriptor readable_;
};

class SupervisorTest : public testing::Test {
 protected:
  void SetUp() override {
    std::filesystem::create_directories(directory_.path() / "jobs");
    store_ = *JobStore::open(directory_.path() / "creepd.db");
    jobs_ = std::make_unique<Jobs>(
        directory_.path() / "jobs",
        JobLimits{.most_unfinished = 100, .memory = std::uint64_t{1} << 40, .least_free = 0}, *store_,
        samples_, [] {});
    begin();
  }

  /// A daemon begins with what is in store and folders; the one before, if any, was killed.
  void begin() {
    supervisor_.reset();
    SupervisorOptions options;
    options.jobs = directory_.path() / "jobs";
    options.stall_limit = stall_limit_;
    supervisor_ = std::make_unique<Supervisor>(options, *store_, samples_, executor_);
    ASSERT_TRUE(supervisor_->recover().ok());
  }
  void turn(int times = 1) {
    for (int i = 0; i < times; ++i) supervisor_->turn();
  }

  std::string submit() { return jobs_->submit(kAlice, {kSpec, "", {}, 0})->job.id; }
  /// A job whose first attempt runs.
  AttemptKey running() {
    const AttemptKey key{submit(), 1};
    turn();
    take_lease(key);
    executor_.say(key, Phase::kRunning);
    turn();
    EXPECT_EQ(job(key.job).state, JobState::kRunning);
    return key;
  }
  Job job(const std::string& id) { return *store_->get(id); }
  Attempt attempt(const AttemptKey& key) { return store_->attempts(key.job, key.number, 1)->at(0); }

  creep::JobDirectory folder(const std::string& id) const {
    return creep::JobDirectory(directory_.path() / "jobs" / id);
  }
  /// As a worker that has had it.
  void take_lease(const AttemptKey& key) {
    std::ofstream(folder(key.job).lease()) << "attempt " << key.number << " process 4711\n";
  }
  /// As a worker that lives.
  creep::FileDescriptor hold_lease(const AttemptKey& key) {
    take_lease(key);
    creep::FileDescriptor lease(::open(folder(key.job).lease().c_str(), O_RDWR | O_CLOEXEC));
    EXPECT_EQ(::flock(lease.get(), LOCK_EX | LOCK_NB), 0);
    return lease;
  }
  void give_verdict(const AttemptKey& key, int exit_code, const char* outcome) {
    ASSERT_TRUE(
        creep::write_verdict(folder(key.job).verdict(), {exit_code, outcome, "because", ""}, key.number)
            .ok());
  }
  void end_back_off(const std::string& id) {
    ASSERT_TRUE(store_
                    ->change(id,
                             [](Job& row) {
                               row.not_before = 0;
                               return absl::OkStatus();
                             })
                    .ok());
  }

  TemporaryDirectory directory_;
  SampleLibrary samples_{directory_.path() / "jobs"};
  std::unique_ptr<JobStore> store_;
  std::unique_ptr<Jobs> jobs_;
  ScriptedExecutor executor_;
  double stall_limit_ = 600.0;
  std::unique_ptr<Supervisor> supervisor_;
};

TEST_F(SupervisorTest, AnAttemptIsInTheStoreBeforeAnythingIsStarted) {
  const std::string id = submit();
  int seen = 0;
  executor_.at_start = [&](const AttemptOrder& order) {
    ++seen;
    EXPECT_EQ(order.key, (AttemptKey{id, 1}));
    EXPECT_EQ(job(id).state, JobState::kRunning);
    EXPECT_EQ(job(id).attempts, 1);
    const Attempt asked = attempt(order.key);
    EXPECT_EQ(asked.state, AttemptState::kAsked);
    EXPECT_EQ(asked.engine, "scripted");
    EXPECT_GT(asked.asked, 0);
  };
  turn();
  EXPECT_EQ(seen, 1);
}

TEST_F(SupervisorTest, WhereAndUnderWhichNameAnAttemptRunsIsKept) {
  const AttemptKey key = running();
  const Attempt now = attempt(key);
  EXPECT_EQ(now.state, AttemptState::kRunning);
  EXPECT_EQ(now.engine_id, "4711");
  EXPECT_EQ(now.place, "n7");
  EXPECT_TRUE(now.started);
  EXPECT_FALSE(now.ended);
}

TEST_F(SupervisorTest, NothingIsStartedWithoutRoom) {
  executor_.slots = 0;
  submit();
  turn(3);
  EXPECT_TRUE(executor_.started.empty());
}

TEST_F(SupervisorTest, NoNewsChangesNothing) {
  stall_limit_ = 0.02;
  begin();
  const AttemptKey key = running();
  const std::uint64_t events = job(key.job).events;
  executor_.say(key, Phase::kUnknown);
  for (int i = 0; i < 5; ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
    turn();
  }
  EXPECT_TRUE(executor_.stopped.empty()) << "silence was taken for a stall";
  executor_.says.clear();
  turn(3);
  EXPECT_EQ(job(key.job).state, JobState::kRunning);
  EXPECT_EQ(job(key.job).events, events);
  EXPECT_EQ(attempt(key).state, AttemptState::kRunning);
  EXPECT_EQ(executor_.started.size(), 1u) << "asked for again while it may run";
}

TEST_F(SupervisorTest, AnAttemptThatRunsWithoutProgressIsKilledAndCountsAsAFault) {
  stall_limit_ = 0.02;
  begin();
  const AttemptKey key = running();
  turn();  // which sees the first progress, of which there is none
  std::this_thread::sleep_for(std::chrono::milliseconds(40));
  turn();
  ASSERT_EQ(executor_.stopped.size(), 1u);
  EXPECT_EQ(executor_.stopped[0], std::pair(key, StopMode::kNow));
  executor_.say(key, Phase::kEnded, Cause::kNone, ProcessEnd{std::nullopt, SIGKILL});
  turn();
  EXPECT_EQ(job(key.job).reason, StateReason::kWorkerStalled);
  EXPECT_EQ(job(key.job).faults, 1);
}

TEST_F(SupervisorTest, AnAttemptThatWaitsInTheEngineIsNotStalled) {
  stall_limit_ = 0.02;
  begin();
  submit();
  turn(2);
  std::this_thread::sleep_for(std::chrono::milliseconds(40));
  turn(2);
  EXPECT_TRUE(executor_.stopped.empty());
}

TEST_F(SupervisorTest, ALostAnswerIsNotAskedForAgainAndNewsShowItRunning) {
  executor_.answer = absl::UnavailableError("the command timed out");
  const AttemptKey key{submit(), 1};
  turn(4);
  EXPECT_EQ(executor_.started.size(), 1u);
  EXPECT_EQ(job(key.job).state, JobState::kRunning);
  EXPECT_EQ(attempt(key).state, AttemptState::kAsked);
  executor_.say(key, Phase::kRunning);
  turn();
  EXPECT_EQ(attempt(key).state, AttemptState::kRunning);
  take_lease(key);
  give_verdict(key, creep::kDone, "completed");
  executor_.say(key, Phase::kEnded);
  turn();
  EXPECT_EQ(job(key.job).state, JobState::kSucceeded);
  EXPECT_EQ(job(key.job).attempts, 1);
  EXPECT_EQ(executor_.started.size(), 1u);
}

TEST_F(SupervisorTest, ALostAnswerOfWhatNeverRanIsNoFaultAndTriedAgain) {
  executor_.answer = absl::UnavailableError("the command timed out");
  const AttemptKey key{submit(), 1};
  turn();
  executor_.say(key, Phase::kEnded, Cause::kNeverRan);
  turn();
  EXPECT_EQ(job(key.job).reason, StateReason::kWorkerLost);
  EXPECT_EQ(job(key.job).faults, 0);
  EXPECT_EQ(attempt(key).cause, Cause::kNeverRan);
  executor_.answer = absl::OkStatus();
  end_back_off(key.job);
  turn();
  ASSERT_EQ(executor_.started.size(), 2u);
  EXPECT_EQ(executor_.started[1].key, (AttemptKey{key.job, 2}));
}

TEST_F(SupervisorTest, WhatIsRefusedForGoodNeverRan) {
  executor_.slots = 10;
  executor_.answer = absl::InternalError("no such program");
  const AttemptKey first{submit(), 1};
  const AttemptKey second{submit(), 1};
  turn();
  EXPECT_EQ(executor_.started.size(), 1u) << "one refusal a turn: a broken program does not eat the queue";
  turn();
  EXPECT_EQ(job(first.job).state, JobState::kQueued);
  EXPECT_EQ(job(first.job).reason, StateReason::kWorkerLost);
  EXPECT_EQ(attempt(first).state, AttemptState::kEnded);
  EXPECT_EQ(attempt(first).cause, Cause::kNeverRan);
}

TEST_F(SupervisorTest, AnEndThatIsToldTwiceIsOneEnd) {
  const AttemptKey key = running();
  executor_.say(key, Phase::kEnded, Cause::kNone, ProcessEnd{3, std::nullopt});
  const AttemptNews news = executor_.says[0];
  turn();
  EXPECT_EQ(job(key.job).faults, 1);
  const std::uint64_t events = job(key.job).events;
  executor_.says = {news, news};
  turn(2);
  EXPECT_EQ(job(key.job).events, events);
  EXPECT_EQ(job(key.job).faults, 1);
  EXPECT_TRUE(executor_.says.empty()) << "an end that is stored is to be forgotten";
  // Nor does it touch the next attempt.
  end_back_off(key.job);
  turn();
  const AttemptKey next{key.job, 2};
  executor_.say(next, Phase::kRunning);
  executor_.says.push_back(news);
  turn(2);
  EXPECT_EQ(job(key.job).state, JobState::kRunning);
  EXPECT_EQ(attempt(next).state, AttemptState::kRunning);
}

TEST_F(SupervisorTest, AnAttemptOutlivesTheDaemonAndIsTakenUp) {
  executor_.survives = true;
  const AttemptKey key = running();
  const auto lease = hold_lease(key);
  supervisor_->start();
  supervisor_->stop();
  EXPECT_TRUE(executor_.stopped.empty()) << "what goes on without the daemon is left alone";
  EXPECT_EQ(job(key.job).state, JobState::kRunning);
  executor_.says.clear();
  begin();
  ASSERT_EQ(executor_.adopted, std::vector<AttemptKey>{key});
  turn(2);
  EXPECT_EQ(job(key.job).state, JobState::kRunning);
  EXPECT_EQ(executor_.started.size(), 1u);
  executor_.say(key, Phase::kRunning);
  turn();
  give_verdict(key, creep::kDone, "completed");
  executor_.say(key, Phase::kEnded);
  turn();
  EXPECT_EQ(job(key.job).state, JobState::kSucceeded);
  EXPECT_EQ(job(key.job).attempts, 1);
  EXPECT_EQ(attempt(key).state, AttemptState::kEnded);
  EXPECT_EQ(attempt(key).process.exit_code, creep::kDone);
}

TEST_F(SupervisorTest, AnAttemptThatEndedWhileTheDaemonWasAwayEndsAsItsVerdictSays) {
  executor_.survives = true;
  const AttemptKey key = running();
  give_verdict(key, creep::kDone, "creep_failure");
  executor_.says.clear();
  executor_.say(key, Phase::kEnded, Cause::kNodeLost);
  begin();
  EXPECT_EQ(job(key.job).state, JobState::kSucceeded);
  EXPECT_EQ(job(key.job).reason, StateReason::kCreepFailure);
}

TEST_F(SupervisorTest, AFormerWorkerKeepsItsOwnJobWaitingAndNobodyElse) {
  executor_.slots = 2;
  const AttemptKey key = running();
  auto lease = hold_lease(key);
  begin();
  const std::string other = submit();
  turn(2);
  EXPECT_EQ(job(key.job).state, JobState::kRunning);
  EXPECT_NE(job(key.job).message.find("waits for its former worker, process 4711"), std::string::npos)
      << job(key.job).message;
  EXPECT_EQ(job(other).state, JobState::kRunning);
  ASSERT_TRUE(jobs_->cancel(kAlice, key.job, false).ok());
  turn(2);
  EXPECT_EQ(job(key.job).reason, StateReason::kCancelRequested);
  lease = creep::FileDescriptor();
  turn();
  EXPECT_EQ(job(key.job).state, JobState::kCancelled);
}

TEST_F(SupervisorTest, ADaemonStopsThoughAFormerWorkerHoldsALease) {
  const AttemptKey key = running();
  const auto lease = hold_lease(key);
  begin();
  supervisor_->start();
  supervisor_->stop();
  EXPECT_EQ(job(key.job).state, JobState::kRunning);
}

TEST_F(SupervisorTest, AWorkerOfADaemonThatWasKilledGivesItsAttemptBack) {
  const AttemptKey key = running();
  begin();
  EXPECT_EQ(job(key.job).state, JobState::kQueued);
  EXPECT_EQ(job(key.job).reason, StateReason::kDaemonStopped);
  EXPECT_EQ(job(key.job).attempts, 0);
  EXPECT_EQ(attempt(key).state, AttemptState::kEnded);
  EXPECT_EQ(attempt(key).cause, Cause::kNone);
}

TEST_F(SupervisorTest, AnAttemptThatADaemonStoredAndDidNotLiveToStartNeverRan) {
  const AttemptKey key{submit(), 1};
  turn();
  executor_.says.clear();
  begin();
  EXPECT_EQ(job(key.job).reason, StateReason::kDaemonStopped);
  EXPECT_EQ(attempt(key).cause, Cause::kNeverRan);
  EXPECT_FALSE(attempt(key).started);
}

TEST_F(SupervisorTest, TheVerdictOutranksTheWordOfTheEngine) {
  for (const Cause cause : {Cause::kNone, Cause::kTimeLimit, Cause::kPreempted, Cause::kNodeLost,
                            Cause::kOutOfMemory, Cause::kStoppedOutside, Cause::kNeverRan}) {
    const AttemptKey key = running();
    const auto lease = hold_lease(key);  // of a worker on a machine that is called lost, about to exit
    give_verdict(key, creep::kDone, "completed");
    executor_.say(key, Phase::kEnded, cause, ProcessEnd{std::nullopt, SIGSEGV});
    turn();
    EXPECT_EQ(job(key.job).state, JobState::kSucceeded) << static_cast<int>(cause);
  }
}

TEST_F(SupervisorTest, AVerdictOfAnEarlierAttemptSaysNothing) {
  const AttemptKey key = running();
  give_verdict({key.job, 7}, creep::kDone, "completed");
  executor_.say(key, Phase::kEnded, Cause::kNone, ProcessEnd{std::nullopt, SIGKILL});
  turn();
  EXPECT_EQ(job(key.job).state, JobState::kQueued);
}

TEST_F(SupervisorTest, AWorkerThatHoldsItsLeaseIsWaitedForWhateverTheEngineSays) {
  executor_.survives = true;
  const AttemptKey key = running();
  auto lease = hold_lease(key);
  executor_.say(key, Phase::kEnded, Cause::kNodeLost);
  turn(3);
  EXPECT_EQ(job(key.job).state, JobState::kRunning);
  EXPECT_NE(job(key.job).message.find("waits for its former worker"), std::string::npos);
  // Another attempt at once would find the lease taken.
  give_verdict(key, creep::kCheckpointed, "checkpointed");
  turn(2);
  EXPECT_EQ(job(key.job).state, JobState::kRunning);
  lease = creep::FileDescriptor();
  turn();
  EXPECT_EQ(job(key.job).state, JobState::kQueued);
  EXPECT_EQ(job(key.job).faults, 0);
}

TEST_F(SupervisorTest, WhatTheEngineDoesIsNeverTheWorkersFaultAndHardlyWaitedOut) {
  for (const Cause cause : {Cause::kTimeLimit, Cause::kPreempted, Cause::kNodeLost, Cause::kStoppedOutside}) {
    AttemptKey key = running();
    for (int i = 0; i < 8; ++i) {
      // Of a worker that had time to checkpoint, that was killed, and that nobody saw.
      const ProcessEnd ends[] = {{creep::kCheckpointed, {}}, {{}, SIGKILL}, {{}, SIGXCPU}, {}};
      executor_.say(key, Phase::kEnded, cause, ends[i % 4]);
      turn();
      const Job row = job(key.job);
      ASSERT_EQ(row.state, JobState::kQueued) << row.message;
      EXPECT_EQ(row.reason, StateReason::kWorkerLost);
      EXPECT_EQ(row.faults, 0);
      EXPECT_LE(row.not_before, wall_clock() + 10'000'000);
      EXPECT_EQ(attempt(key).cause, cause);
      end_back_off(key.job);
      turn();
      ++key.number;
      take_lease(key);
    }
    ASSERT_TRUE(jobs_->cancel(kAlice, key.job, true).ok());
    executor_.say(key, Phase::kEnded, cause);
    turn();
    EXPECT_EQ(job(key.job).state, JobState::kCancelled);
  }
}

TEST_F(SupervisorTest, OutOfMemoryOfTheEngineIsAFaultOfTheJob) {
  AttemptKey key = running();
  for (; key.number <= 3; ++key.number) {
    take_lease(key);
    executor_.say(key, Phase::kEnded, Cause::kOutOfMemory, ProcessEnd{1, std::nullopt});
    turn();
    if (key.number == 3) break;
    end_back_off(key.job);
    turn();
  }
  EXPECT_EQ(job(key.job).state, JobState::kFailed);
  EXPECT_EQ(job(key.job).reason, StateReason::kCrashLoop);
}

TEST_F(SupervisorTest, WhatIsAskedOfARunningJobIsAskedOnceOfItsExecutor) {
  const AttemptKey key = running();
  ASSERT_TRUE(jobs_->pause(kAlice, key.job).ok());
  turn(3);
  ASSERT_TRUE(jobs_->cancel(kAlice, key.job, true).ok());
  turn(3);
  EXPECT_EQ(executor_.stopped, (std::vector<std::pair<AttemptKey, StopMode>>{{key, StopMode::kCheckpoint},
                                                                             {key, StopMode::kNow}}));
}

}  // namespace
}  // namespace creepd
