#include "server/rules/attempt_ending.h"

#include <algorithm>
#include <csignal>
#include <cstring>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"

namespace creepd {
namespace {

void become(Job& job, JobState state, StateReason reason, std::string message) {
  job.state = state;
  job.reason = reason;
  job.message = std::move(message);
}

/// Ended by the wish of somebody outside, or by the machine: no fault of the worker.
bool is_outside_signal(int number) {
  return number == SIGKILL || number == SIGTERM || number == SIGINT || number == SIGHUP;
}

/// What the engine says that lies with neither the worker nor its job.
bool is_of_engine(Cause cause) {
  switch (cause) {
    case Cause::kTimeLimit:
    case Cause::kPreempted:
    case Cause::kNodeLost:
    case Cause::kStoppedOutside:
      return true;
    case Cause::kNone:
    case Cause::kOutOfMemory:
    case Cause::kNeverRan:
      return false;
  }
  return false;
}

bool no_fault_of_worker(const AttemptEnd& end) {
  if (is_of_engine(end.cause) || end.cause == Cause::kNeverRan) return true;
  if (exit_code_of(end) == creep::kLeaseHeld) return true;
  if (exit_code_of(end)) return false;
  return !end.process.signal || is_outside_signal(*end.process.signal);
}

/// What the engine does to an attempt in the ordinary course of things is not waited out for long.
constexpr double kMostSecondsAfterEngine = 10.0;

void wait_before_next(Job& job, Cause cause, Moment now) {
  ++job.losses;
  double seconds = back_off_seconds(job.losses);
  if (is_of_engine(cause)) seconds = std::min(seconds, kMostSecondsAfterEngine);
  job.not_before = now + static_cast<Moment>(seconds * 1e6);
}

std::string described(const AttemptEnd& end) {
  if (end.stalled) return "the worker made no progress and was killed";
  switch (end.cause) {
    case Cause::kTimeLimit:
      return "the attempt reached the time limit of its place";
    case Cause::kPreempted:
      return "the attempt gave way to something more urgent";
    case Cause::kNodeLost:
      return "the machine of the attempt was lost";
    case Cause::kOutOfMemory:
      return "the worker got no more memory";
    case Cause::kStoppedOutside:
      return "the worker was stopped from outside";
    case Cause::kNeverRan:
      return "the worker could not be started";
    case Cause::kNone:
      break;
  }
  if (const auto code = exit_code_of(end)) return absl::StrCat("the worker ended with exit code ", *code);
  if (const auto number = end.process.signal)
    return absl::StrCat("the worker was ended by signal ", *number, " (", ::strsignal(*number), ")");
  return "the worker disappeared";
}

void count_fault(Job& job, const AttemptEnd& end, StateReason reason, Moment now) {
  ++job.faults;
  if (job.faults >= kMostFaults) {
    become(job, JobState::kFailed, StateReason::kCrashLoop,
           absl::StrCat(described(end), "; ", job.faults,
                        " attempts in a row failed like that without a new checkpoint"));
    return;
  }
  become(job, JobState::kQueued, reason,
         absl::StrCat(described(end), "; tried again (fault ", job.faults, " of ", kMostFaults, ")"));
  wait_before_next(job, end.cause, now);
}

/// What was asked of the job while it ran has come about. False if nothing was asked.
bool fulfil_request(Job& job) {
  if (job.reason == StateReason::kCancelRequested) {
    become(job, JobState::kCancelled, StateReason::kCancelledByUser, "cancelled");
    return true;
  }
  if (job.reason == StateReason::kPauseRequested) {
    become(job, JobState::kPaused, StateReason::kPausedByUser, "paused; resume it to go on");
    return true;
  }
  return false;
}

std::string said_by(const creep::Ending& verdict) {
  return absl::StrCat(verdict.reason, verdict.advice.empty() ? "" : ". ", verdict.advice);
}

/// Nothing of a refused job is lost, but its state is final and its worker has no caller to give it options.
std::string way_on(const Job& job, const AttemptEnd& end) {
  if (!end.verdict) return "";
  std::string way = " There a fork of this job goes on from its last checkpoint.";
  if (absl::StrContains(said_by(*end.verdict), "--allow-inexact")) {
    absl::StrAppend(&way, " Here: creepctl fetch ", job.id,
                    " --out DIR && creepctl run DIR/job.toml --out DIR ", "--allow-inexact");
  }
  return way;
}

/// The endings that the worker itself decided on. False if this was none of them.
bool conclude_by_verdict(Job& job, const AttemptEnd& end) {
  const auto code = exit_code_of(end);
  if (!code) return false;
  const std::string said = end.verdict ? said_by(*end.verdict) : absl::StrCat("exit code ", *code);
  const std::string outcome = end.verdict ? end.verdict->outcome : "";
  switch (*code) {
    case creep::kDone:
      job.state_digest = end.state_digest;
      become(job, JobState::kSucceeded,
             outcome == "creep_failure" ? StateReason::kCreepFailure : StateReason::kCompleted, said);
      return true;
    case creep::kBadInput:
      become(job, JobState::kFailed, StateReason::kBadInput, said);
      return true;
    case creep::kRefused:
      if (outcome == "guard_stop") {
        become(job, JobState::kFailed, StateReason::kGuardStop, said);
      } else {
        become(job, JobState::kFailed, StateReason::kRefused, absl::StrCat(said, way_on(job, end)));
      }
      return true;
    default:
      return false;
  }
}

/// What a worker logged that could not write its verdict.
std::string last_line(std::string text) {
  while (!text.empty() && text.back() == '\n') text.pop_back();
  const std::size_t start = text.rfind('\n');
  text = start == std::string::npos ? text : text.substr(start + 1);
  return text.empty() ? "input or output failed" : text;
}

void conclude_io_error(Job& job, const AttemptEnd& end, Moment now) {
  const std::string said = end.verdict ? end.verdict->reason : last_line(end.log_tail);
  const auto says = [&](const char* words) { return said.find(words) != std::string::npos; };
  const bool full =
      end.disk_full || says("No space left") || says("quota exceeded") || says("File too large");
  if (full) {
    become(job, JobState::kPaused, StateReason::kDiskFull,
           absl::StrCat(said, "; goes on by itself once there is room"));
    wait_before_next(job, end.cause, now);
  } else {
    become(job, JobState::kPaused, StateReason::kIoError,
           absl::StrCat(said, "; check the storage, then resume the job"));
  }
}

/// Nobody asked for this ending: it counts as a fault, or the job waits for its turn or for room.
void conclude_unasked(Job& job, const AttemptEnd& end, Moment now) {
  const auto code = exit_code_of(end);
  if (code == creep::kIoError) {
    conclude_io_error(job, end, now);
  } else if (end.daemon_stopped && (code == creep::kCheckpointed || no_fault_of_worker(end))) {
    job.attempts = std::max(0, job.attempts - 1);
    become(job, JobState::kQueued, StateReason::kDaemonStopped, "the daemon was stopped; goes on by itself");
  } else if (code == creep::kCheckpointed && !is_of_engine(end.cause)) {
    const bool resumed = job.reason == StateReason::kResumed;
    become(job, JobState::kQueued, resumed ? StateReason::kResumed : StateReason::kWorkerLost,
           resumed ? "resumed" : "the worker was asked from outside to stop; goes on by itself");
    if (!resumed) wait_before_next(job, end.cause, now);
  } else if (end.stalled) {
    count_fault(job, end, StateReason::kWorkerStalled, now);
  } else if (end.cause == Cause::kOutOfMemory || code == creep::kOutOfMemory) {
    count_fault(job, end, StateReason::kOutOfMemory, now);
  } else if (no_fault_of_worker(end)) {
    become(job, JobState::kQueued, StateReason::kWorkerLost,
           absl::StrCat(described(end), "; goes on by itself"));
    wait_before_next(job, end.cause, now);
  } else {
    count_fault(job, end, StateReason::kWorkerCrashed, now);
  }
}

}  // namespace

double back_off_seconds(int losses) {
  return losses <= 0 ? 0.0 : std::min(60.0, static_cast<double>(1 << std::min(losses - 1, 6)));
}

std::optional<int> exit_code_of(const AttemptEnd& end) {
  return end.verdict ? end.verdict->exit_code : end.process.exit_code;
}

bool is_over(const std::optional<creep::Ending>& verdict, bool lease_is_held) {
  if (!lease_is_held) return true;
  // 75 is followed by another attempt at once, which would find the lease taken.
  return verdict && verdict->exit_code != creep::kCheckpointed;
}

void conclude(Job& job, const AttemptEnd& end, Moment now) {
  if (end.checkpoint > job.checkpoint) {
    job.faults = 0;
    job.losses = 0;
  }
  job.checkpoint = std::max(job.checkpoint, end.checkpoint);
  // A run that ended while it was asked to stop has ended: there is nothing left to pause or cancel.
  if (!conclude_by_verdict(job, end) && !fulfil_request(job)) conclude_unasked(job, end, now);
  job.stop_now = false;
  if (job.state == JobState::kFailed) job.log_tail = end.log_tail;
  if (is_final(job.state)) job.ended = now;
}

}  // namespace creepd
