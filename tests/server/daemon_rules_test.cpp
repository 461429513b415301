// The daemon's rules without files or processes: changes of state, ends of attempts, numbers of events.
#include <gtest/gtest.h>
#include <signal.h>

#include <vector>

#include "server/rules/attempt_ending.h"
#include "server/rules/event_feed.h"
#include "server/rules/job.h"
#include "server/rules/refusal.h"

namespace creepd {
namespace {

constexpr JobState kStates[] = {JobState::kQueued,    JobState::kRunning, JobState::kPaused,
                                JobState::kSucceeded, JobState::kFailed,  JobState::kCancelled};
constexpr Moment kNow = 1'000'000'000;

Job running_job() {
  Job job;
  job.id = "abcd";
  job.state = JobState::kRunning;
  job.reason = StateReason::kNone;
  job.attempts = 1;
  job.lease_attempt = 1;
  return job;
}

Job run_again(Job job) {
  job.state = JobState::kRunning;
  job.reason = StateReason::kNone;
  ++job.attempts;
  return job;
}

AttemptEnd exit_with(int code, const char* outcome = "", const char* reason = "because") {
  AttemptEnd end;
  end.process.exit_code = code;
  if (*outcome != '\0') end.verdict = creep::Ending{code, outcome, reason, ""};
  return end;
}

AttemptEnd signalled(int number) {
  AttemptEnd end;
  end.process.signal = number;
  return end;
}

TEST(JobStates, NothingLeadsOutOfAFinalState) {
  for (const JobState from : kStates) {
    for (const JobState to : kStates) {
      EXPECT_FALSE(is_final(from) && is_legal(from, to)) << state_name(from) << " to " << state_name(to);
    }
  }
}

TEST(JobStates, OnlyARunningJobSucceedsOrFails) {
  for (const JobState from : kStates) {
    EXPECT_EQ(is_legal(from, JobState::kSucceeded), from == JobState::kRunning);
    EXPECT_EQ(is_legal(from, JobState::kFailed), from == JobState::kRunning);
  }
}

TEST(JobStates, OnlyAQueuedJobStarts) {
  for (const JobState from : kStates) {
    EXPECT_EQ(is_legal(from, JobState::kRunning), from == JobState::kQueued || from == JobState::kRunning);
  }
}

TEST(AttemptEnding, EveryEndBringsALegalState) {
  for (int code = 0; code < 256; ++code) {
    for (const bool stopped : {false, true}) {
      for (const StateReason asked : {StateReason::kNone, StateReason::kPauseRequested,
                                      StateReason::kCancelRequested, StateReason::kResumed}) {
        Job job = running_job();
        job.reason = asked;
        AttemptEnd end = exit_with(code);
        end.daemon_stopped = stopped;
        conclude(job, end, kNow);
        EXPECT_NE(job.state, JobState::kRunning) << code;
        EXPECT_TRUE(is_legal(JobState::kRunning, job.state)) << code;
        EXPECT_EQ(job.ended.has_value(), is_final(job.state)) << code;
      }
    }
  }
}

TEST(AttemptEnding, ACreepFailureIsASuccess) {
  Job job = running_job();
  AttemptEnd end = exit_with(creep::kDone, "creep_failure");
  end.state_digest = "d1";
  conclude(job, end, kNow);
  EXPECT_EQ(job.state, JobState::kSucceeded);
  EXPECT_EQ(job.reason, StateReason::kCreepFailure);
  EXPECT_EQ(job.state_digest, "d1");
}

TEST(AttemptEnding, AGuardStopAndARefusalAreNeverTriedAgain) {
  Job guard = running_job();
  conclude(guard, exit_with(creep::kRefused, "guard_stop"), kNow);
  EXPECT_EQ(guard.state, JobState::kFailed);
  EXPECT_EQ(guard.reason, StateReason::kGuardStop);
  Job refused = running_job();
  conclude(refused, exit_with(creep::kRefused, "refused"), kNow);
  EXPECT_EQ(refused.reason, StateReason::kRefused);
  EXPECT_NE(refused.message.find("a fork of this job goes on"), std::string::npos);
  EXPECT_EQ(refused.message.find("creepctl run"), std::string::npos);
  Job inexact = running_job();
  conclude(inexact, exit_with(creep::kRefused, "refused", "other arithmetic; --allow-inexact continues it"),
           kNow);
  EXPECT_NE(inexact.message.find("creepctl run DIR/job.toml --out DIR --allow-inexact"), std::string::npos);
  Job bad = running_job();
  conclude(bad, exit_with(creep::kBadInput, "bad_input"), kNow);
  EXPECT_EQ(bad.reason, StateReason::kBadInput);
}

TEST(AttemptEnding, ThreeFaultsWithoutANewCheckpointFailTheJobWithTheLog) {
  Job job = running_job();
  conclude(job, signalled(SIGSEGV), kNow);
  EXPECT_EQ(job.state, JobState::kQueued);
  EXPECT_EQ(job.reason, StateReason::kWorkerCrashed);
  job = run_again(job);
  conclude(job, exit_with(3), kNow);
  EXPECT_EQ(job.state, JobState::kQueued);
  job = run_again(job);
  AttemptEnd third = exit_with(creep::kOutOfMemory);
  third.log_tail = "last words";
  conclude(job, third, kNow);
  EXPECT_EQ(job.state, JobState::kFailed);
  EXPECT_EQ(job.reason, StateReason::kCrashLoop);
  EXPECT_EQ(job.log_tail, "last words");
}

TEST(AttemptEnding, ANewCheckpointForgivesEarlierFaults) {
  Job job = running_job();
  for (std::uint64_t generation = 1; generation <= 10; ++generation) {
    AttemptEnd end = signalled(SIGABRT);
    end.checkpoint = generation;
    conclude(job, end, kNow);
    ASSERT_EQ(job.state, JobState::kQueued);
    EXPECT_EQ(job.faults, 1);
    job = run_again(job);
  }
}

TEST(AttemptEnding, KillsFromOutsideNeverFailAJobButAreBackedOff) {
  Job job = running_job();
  for (int i = 1; i <= 20; ++i) {
    conclude(job, signalled(SIGKILL), kNow);
    ASSERT_EQ(job.state, JobState::kQueued);
    EXPECT_EQ(job.reason, StateReason::kWorkerLost);
    EXPECT_EQ(job.faults, 0);
    EXPECT_EQ(job.not_before, kNow + static_cast<Moment>(back_off_seconds(i) * 1e6));
    job = run_again(job);
  }
  EXPECT_DOUBLE_EQ(back_off_seconds(1), 1.0);
  EXPECT_DOUBLE_EQ(back_off_seconds(1000), 60.0);
}

TEST(AttemptEnding, AVerdictOutranksWhatTheEngineSaysOfTheEnd) {
  for (const Cause cause : {Cause::kTimeLimit, Cause::kPreempted, Cause::kNodeLost, Cause::kNeverRan}) {
    Job job = running_job();
    AttemptEnd end = exit_with(creep::kDone, "completed");
    end.process = {std::nullopt, SIGSEGV};
    end.cause = cause;
    conclude(job, end, kNow);
    EXPECT_EQ(job.state, JobState::kSucceeded);
  }
}

TEST(AttemptEnding, AnAttemptIsOverWhenNobodyHoldsItsLeaseOrItsLastWordIsSaid) {
  const creep::Ending done{creep::kDone, "completed", "", ""};
  const creep::Ending again{creep::kCheckpointed, "checkpointed", "", ""};
  EXPECT_TRUE(is_over(std::nullopt, false));
  EXPECT_FALSE(is_over(std::nullopt, true));
  EXPECT_TRUE(is_over(done, true));
  EXPECT_FALSE(is_over(again, true));
  EXPECT_TRUE(is_over(again, false));
}

TEST(AttemptEnding, AKillForMemoryIsAFault) {
  Job job = running_job();
  AttemptEnd end = signalled(SIGKILL);
  end.cause = Cause::kOutOfMemory;
  conclude(job, end, kNow);
  EXPECT_EQ(job.reason, StateReason::kOutOfMemory);
  EXPECT_EQ(job.faults, 1);
}

TEST(AttemptEnding, AStopOfTheDaemonGivesTheAttemptBack) {
  for (AttemptEnd end : {exit_with(creep::kCheckpointed, "checkpointed"), signalled(SIGKILL), AttemptEnd{}}) {
    Job job = running_job();
    end.daemon_stopped = true;
    conclude(job, end, kNow);
    EXPECT_EQ(job.state, JobState::kQueued);
    EXPECT_EQ(job.reason, StateReason::kDaemonStopped);
    EXPECT_EQ(job.attempts, 0);
    EXPECT_EQ(job.not_before, 0);
  }
}

TEST(AttemptEnding, ACrashCountsAlsoWhileTheDaemonStops) {
  Job job = running_job();
  AttemptEnd end = signalled(SIGSEGV);
  end.daemon_stopped = true;
  conclude(job, end, kNow);
  EXPECT_EQ(job.faults, 1);
}

TEST(AttemptEnding, WhatWasAskedComesAboutHoweverTheWorkerEnds) {
  for (const AttemptEnd& end : {exit_with(creep::kCheckpointed), signalled(SIGKILL), signalled(SIGSEGV),
                                exit_with(creep::kIoError)}) {
    Job pause = running_job();
    pause.reason = StateReason::kPauseRequested;
    conclude(pause, end, kNow);
    EXPECT_EQ(pause.state, JobState::kPaused);
    EXPECT_EQ(pause.reason, StateReason::kPausedByUser);
    Job cancel = running_job();
    cancel.reason = StateReason::kCancelRequested;
    conclude(cancel, end, kNow);
    EXPECT_EQ(cancel.state, JobState::kCancelled);
  }
}

TEST(AttemptEnding, ARunThatEndedBeforeItWasStoppedHasEnded) {
  Job job = running_job();
  job.reason = StateReason::kCancelRequested;
  conclude(job, exit_with(creep::kDone, "completed"), kNow);
  EXPECT_EQ(job.state, JobState::kSucceeded);
}

TEST(AttemptEnding, AFullDiskPausesUntilThereIsRoomOtherTroubleUntilSomebodyLooks) {
  Job full = running_job();
  conclude(full, exit_with(creep::kIoError, "io_error", "write samples.log: No space left on device"), kNow);
  EXPECT_EQ(full.state, JobState::kPaused);
  EXPECT_EQ(full.reason, StateReason::kDiskFull);
  Job no_verdict = running_job();
  AttemptEnd end = exit_with(creep::kIoError);
  end.disk_full = true;
  conclude(no_verdict, end, kNow);
  EXPECT_EQ(no_verdict.reason, StateReason::kDiskFull);
  Job log_only = running_job();
  AttemptEnd told_by_log = exit_with(creep::kIoError);
  told_by_log.log_tail = "checkpoint 1\nended 74 (io_error): write samples.csv: No space left on device\n";
  conclude(log_only, told_by_log, kNow);
  EXPECT_EQ(log_only.reason, StateReason::kDiskFull);
  Job broken = running_job();
  conclude(broken, exit_with(creep::kIoError, "io_error", "read ck.3: Input/output error"), kNow);
  EXPECT_EQ(broken.reason, StateReason::kIoError);
}

/// All events a reader gets that takes each as it comes.
std::vector<FeedStep> read_all(const std::vector<StateEvent>& changes, std::uint64_t samples,
                               std::uint64_t readable, std::uint64_t after = 0) {
  std::vector<FeedStep> steps;
  while (const auto step = next_event(changes, samples, readable, after)) {
    EXPECT_GT(step->seq, after);
    EXPECT_EQ(step->skipped, step->seq - after - 1);
    after = step->seq;
    steps.push_back(*step);
  }
  return steps;
}

StateEvent change_after(std::uint64_t samples) {
  StateEvent event;
  event.samples_before = samples;
  return event;
}

TEST(EventFeed, NumbersChangesAndSamplesTogetherWithoutGap) {
  const std::vector<StateEvent> changes = {change_after(0), change_after(0), change_after(3),
                                           change_after(5)};
  const auto steps = read_all(changes, 5, 5);
  ASSERT_EQ(steps.size(), 9u);
  std::uint64_t samples = 0;
  std::size_t seen = 0;
  for (std::size_t i = 0; i < steps.size(); ++i) {
    EXPECT_EQ(steps[i].seq, i + 1);
    EXPECT_EQ(steps[i].skipped, 0u);
    if (steps[i].change) {
      EXPECT_EQ(*steps[i].change, seen++);
      EXPECT_EQ(changes[*steps[i].change].samples_before, samples);
    } else {
      EXPECT_EQ(*steps[i].sample, samples++);
    }
  }
}

TEST(EventFeed, GivesTheSameNumbersWhereverAReaderBegins) {
  const std::vector<StateEvent> changes = {change_after(0), change_after(2), change_after(2),
                                           change_after(7)};
  const auto all = read_all(changes, 9, 9);
  for (std::uint64_t after = 0; after <= all.size(); ++after) {
    const auto rest = read_all(changes, 9, 9, after);
    ASSERT_EQ(rest.size(), all.size() - after);
    for (std::size_t i = 0; i < rest.size(); ++i) {
      EXPECT_EQ(rest[i].seq, all[after + i].seq);
      EXPECT_EQ(rest[i].sample, all[after + i].sample);
      EXPECT_EQ(rest[i].change, all[after + i].change);
    }
  }
}

TEST(EventFeed, WhatComesLaterDoesNotChangeEarlierNumbers) {
  std::vector<StateEvent> changes = {change_after(0), change_after(1)};
  const auto before = read_all(changes, 4, 4);
  changes.push_back(change_after(4));
  const auto after = read_all(changes, 8, 8);
  for (std::size_t i = 0; i < before.size(); ++i) EXPECT_EQ(before[i].sample, after[i].sample);
}

TEST(EventFeed, AReaderFarBehindGetsTheNewestSampleAndEveryChange) {
  const std::vector<StateEvent> changes = {change_after(0), change_after(5000), change_after(20000)};
  const auto steps = read_all(changes, 30000, 30000);
  std::size_t seen = 0;
  std::uint64_t skipped = 0;
  for (const FeedStep& step : steps) {
    seen += step.change ? 1 : 0;
    skipped += step.skipped;
  }
  EXPECT_EQ(seen, changes.size());
  EXPECT_EQ(*steps.back().sample, 29999u);
  EXPECT_EQ(skipped + steps.size(), 30003u);
  EXPECT_LE(steps.size(), changes.size() + 1);
}

TEST(EventFeed, AReaderThatLooksOnGetsTheNewestSampleAndEveryChange) {
  std::vector<StateEvent> changes = {change_after(0)};
  std::uint64_t after = 1;
  std::uint64_t samples = 0;
  std::size_t seen = 1;
  for (int telling = 1; telling <= 50; ++telling) {
    samples += 16;
    if (telling % 10 == 0) {
      changes.push_back(change_after(samples - 7));
      changes.push_back(change_after(samples - 7));
    }
    int sent = 0;
    while (const auto step = next_event(changes, samples, samples, after, kMostLiveBacklog)) {
      EXPECT_EQ(step->seq, after + step->skipped + 1);
      if (step->change) EXPECT_EQ(*step->change, seen++);
      sent += step->sample ? 1 : 0;
      after = step->seq;
    }
    EXPECT_EQ(sent, 1);
  }
  EXPECT_EQ(seen, changes.size());
  EXPECT_EQ(after, samples + changes.size());
}

TEST(EventFeed, AChangeIsToldThoughSamplesBeforeItWereLostInAPowerCut) {
  const std::vector<StateEvent> changes = {change_after(0), change_after(10)};
  const auto steps = read_all(changes, 10, 4);
  ASSERT_EQ(steps.size(), 6u);  // a change, four samples, a change
  EXPECT_EQ(steps.back().change, 1u);
  EXPECT_EQ(steps.back().skipped, 6u);
  EXPECT_EQ(steps.back().seq, 12u);
}

TEST(EventFeed, WaitsForSamplesThatAreComputedAgain) {
  const std::vector<StateEvent> changes = {change_after(0)};
  EXPECT_EQ(read_all(changes, 10, 4).size(), 5u);
}

TEST(Refusal, CarriesAllThatIsWrongThroughAStatus) {
  const absl::Status status = refuse(absl::StatusCode::kInvalidArgument, "wrong",
                                     {"BAD_REQUEST", {{"limit", "3"}}, {{"a", "first"}, {"b", "second"}}, 7});
  const Refusal refusal = refusal_of(status);
  EXPECT_EQ(refusal.reason, "BAD_REQUEST");
  ASSERT_EQ(refusal.facts.size(), 1u);
  EXPECT_EQ(refusal.facts[0].second, "3");
  ASSERT_EQ(refusal.violations.size(), 2u);
  EXPECT_EQ(refusal.violations[1].field, "b");
  EXPECT_EQ(refusal.retry_seconds, 7);
  EXPECT_EQ(refusal_of(absl::UnavailableError("other")).reason, "");
}

}  // namespace
}  // namespace creepd
