// What the end of an attempt means for its job: the policy for crashes, kills, full disks and requests. Pure.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "core/folder/ending.h"
#include "server/rules/attempt.h"
#include "server/rules/job.h"

namespace creepd {

/// How an attempt ended, as the daemon saw or reconstructed it.
struct AttemptEnd {
  ProcessEnd process;                    ///< as its executor saw it
  std::optional<creep::Ending> verdict;  ///< verdict.json of this attempt: outranks all that others say
  Cause cause = Cause::kNone;
  bool daemon_stopped = false;   ///< the daemon went down, or had gone down, meanwhile
  bool stalled = false;          ///< the daemon killed it for making no progress
  bool disk_full = false;        ///< too little room is left
  std::uint64_t checkpoint = 0;  ///< newest generation now
  std::string state_digest;      ///< of summary.json
  std::string log_tail;
};

/// The exit code that the attempt stands by: that of its verdict, else that of its process.
std::optional<int> exit_code_of(const AttemptEnd& end);

/// Whether an attempt that its executor calls ended is over. A worker that holds the lease lives, wherever it
/// is; one that has said its last word is not waited for.
bool is_over(const std::optional<creep::Ending>& verdict, bool lease_is_held);

/// Three faults in a row without a new checkpoint end a job.
inline constexpr int kMostFaults = 3;

/// Seconds to wait before attempt after so many losses in a row: 1, 2, 4, ... 60.
double back_off_seconds(int losses);

/// Brings a RUNNING job into the state that follows. `now`: wall clock.
///
/// Own faults of the worker (a crash signal, an unknown exit code, memory, a stall) are counted, kills from
/// outside, limits of time, preemption and lost machines are not; what a stop of the daemon ended is given
/// back.
void conclude(Job& job, const AttemptEnd& end, Moment now);

}  // namespace creepd
