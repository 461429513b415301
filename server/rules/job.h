// A job as the daemon knows it: its state, why, and which changes of state there are. Pure values.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace creepd {

/// Stored in the database and sent on the wire: numbers are never used again for something else.
enum class JobState : std::uint8_t {
  kQueued = 1,
  kRunning = 2,
  kPaused = 3,
  kSucceeded = 4,
  kFailed = 5,
  kCancelled = 6,
};

/// Why a job is in its state; the meanings are in creep.proto. Stored and sent like JobState.
enum class StateReason : std::uint8_t {
  kNone = 0,
  kSubmitted = 1,
  kResumed = 2,
  kDaemonStopped = 3,
  kWorkerLost = 4,
  kWorkerCrashed = 5,
  kWorkerStalled = 6,
  kOutOfMemory = 7,
  kPauseRequested = 10,
  kCancelRequested = 11,
  kPausedByUser = 20,
  kDiskFull = 21,
  kIoError = 22,
  kCompleted = 30,
  kCreepFailure = 31,
  kCrashLoop = 40,
  kGuardStop = 41,
  kRefused = 42,
  kBadInput = 43,
  kCancelledByUser = 50,
};

/// "QUEUED", ...; as in creep.proto.
const char* state_name(JobState state);

/// No way leads out of a final state.
bool is_final(JobState state);

/// The table of changes. A job may also keep its state and change the reason, unless it is final.
bool is_legal(JobState from, JobState to);

/// Wall-clock moment of the daemon [us since 1970].
using Moment = std::int64_t;

struct Job {
  std::string id;
  std::int64_t number = 0;  ///< in order of submission, from 1
  std::string owner;        ///< "uid:1000"
  std::string name;
  JobState state = JobState::kQueued;
  StateReason reason = StateReason::kSubmitted;
  std::string message;  ///< one sentence for people
  std::string log_tail;
  std::int32_t priority = 0;
  std::map<std::string, std::string> labels;
  std::string spec;  ///< empty in lists
  std::vector<std::string> warnings;
  std::string experiment_hash;
  std::string state_digest;
  std::uint64_t memory_estimate = 0;  ///< [bytes]
  std::string parent;
  std::uint64_t parent_generation = 0;
  Moment submitted = 0;
  std::optional<Moment> started;
  std::optional<Moment> ended;

  // Attempts. Counted and stored before the worker starts, so that a job that kills its machine is counted
  // too.
  std::int32_t attempts = 0;       ///< counted ones; a stop of the daemon gives one back
  std::int64_t lease_attempt = 0;  ///< number of the last lease asked for; never falls
  std::int32_t faults = 0;         ///< in a row by the worker's own fault, without a new checkpoint between
  std::int32_t losses = 0;         ///< in a row of any kind that call for a back-off
  std::uint64_t checkpoint = 0;    ///< newest generation when the last attempt began or ended
  Moment not_before = 0;           ///< back-off: no attempt earlier
  bool stop_now = false;           ///< cancelled without a checkpoint

  // Progress: durable before anybody hears of it.
  std::uint64_t samples = 0;  ///< in the log, told to watchers
  std::uint64_t events = 0;   ///< changes of state so far
  std::string latest_sample;  ///< creep::encode of the record; "" before the first
  std::string progress;       ///< JSON of the worker; "" before the first attempt

  /// Number of the newest event (event_feed.h).
  std::uint64_t last_seq() const { return samples + events; }
};

/// One change of state in the life of a job.
struct StateEvent {
  std::uint64_t samples_before = 0;  ///< samples told before it: places it among them
  JobState state = JobState::kQueued;
  StateReason reason = StateReason::kNone;
  std::string message;
  std::int32_t attempt = 0;
  Moment moment = 0;
};

}  // namespace creepd
