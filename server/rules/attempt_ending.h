// What the end of an attempt means for its job: the policy for crashes, kills, full disks and requests. Pure.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "core/folder/ending.h"
#include "server/rules/job.h"

namespace creepd {

/// How the worker's process ended, as the daemon saw or reconstructed it.
struct AttemptEnd {
  std::optional<int> exit_code;          ///< nothing if a signal ended it, or if nobody knows
  std::optional<int> signal;             ///< that ended it
  std::optional<creep::Ending> verdict;  ///< verdict.json of this attempt, if there is one
  bool daemon_stopped = false;           ///< the daemon went down, or had gone down, meanwhile
  bool stalled = false;                  ///< the daemon killed it for making no progress
  bool out_of_memory = false;            ///< the kernel reported a kill for memory
  bool disk_full = false;                ///< too little room is left
  bool never_started = false;            ///< the process could not be made
  std::uint64_t checkpoint = 0;          ///< newest generation now
  std::string state_digest;              ///< of summary.json
  std::string log_tail;
};

/// Three faults in a row without a new checkpoint end a job.
inline constexpr int kMostFaults = 3;

/// Seconds to wait before attempt after so many losses in a row: 1, 2, 4, ... 60.
double back_off_seconds(int losses);

/// Brings a RUNNING job into the state that follows. `now`: wall clock.
///
/// Own faults of the worker (a crash signal, an unknown exit code, memory, a stall) are counted, kills from
/// outside are not; what a stop of the daemon ended is given back.
void conclude(Job& job, const AttemptEnd& end, Moment now);

}  // namespace creepd
