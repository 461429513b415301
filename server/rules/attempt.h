// One attempt to compute a job: who carries it out, where it ran, how it ended. Pure values; the store keeps
// them.
#pragma once

#include <compare>
#include <cstdint>
#include <optional>
#include <string>

#include "server/rules/job.h"

namespace creepd {

/// The number is that of the lease (Job::lease_attempt): never used again for the job.
struct AttemptKey {
  std::string job;
  std::int64_t number = 0;

  auto operator<=>(const AttemptKey&) const = default;
};

/// How a process ended: one of them, or neither if nobody saw it end.
struct ProcessEnd {
  std::optional<int> exit_code;
  std::optional<int> signal;
};

/// Why an attempt ended, as far as whoever carried it out knows better than its exit code. Stored in the
/// database and sent on the wire: numbers are never used again for something else.
enum class Cause : std::uint8_t {
  kNone = 0,
  kTimeLimit = 1,       ///< it had run as long as it may at a time
  kPreempted = 2,       ///< something more urgent took its place
  kNodeLost = 3,        ///< its machine went away
  kOutOfMemory = 4,     ///< it was killed for memory
  kStoppedOutside = 5,  ///< somebody else stopped it
  kNeverRan = 6,        ///< its worker never took the job folder
};

/// Stored and sent like Cause.
enum class AttemptState : std::uint8_t {
  kAsked = 1,    ///< durable before anything is started; whether it was is not known yet
  kWaiting = 2,  ///< whoever is to carry it out has it and will
  kRunning = 3,
  kEnded = 4,
};

struct Attempt {
  std::int64_t number = 0;
  std::string engine;     ///< who carries it out: "local"
  std::string engine_id;  ///< its name there; "" before it has one
  AttemptState state = AttemptState::kAsked;
  Moment asked = 0;
  std::optional<Moment> started;
  std::optional<Moment> ended;  ///< when its end was seen
  std::string place;            ///< "process 4711"
  ProcessEnd process;           ///< with kEnded
  Cause cause = Cause::kNone;
  std::string words;  ///< for people: how it stands, how it ended
};

}  // namespace creepd
