// What carries out attempts: here, or on the machines of a batch system. Only values cross this line.
//
// The supervisor has the policy: which job is next, what an end means for it, when to stop an attempt. An
// executor has the mechanism: starting, signalling and observing. It may be wrong, late, or silent for a
// while; news may come twice or not at all. So
//   - an attempt is in the store before it is started, and its number is its name: starting is never
//   repeated,
//   - what an executor does not mention, or calls kUnknown, changes nothing,
//   - kEnded is told again and again until forget(): a lost turn loses no end,
//   - the verdict in the job folder outranks what an executor says about an end, and the lease that a worker
//     holds outranks that it has ended (is_over() in attempt_ending.h).
//
// One thread calls all of it, and no call waits for anything that can hang.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "server/rules/attempt.h"

namespace creepd {

struct AttemptOrder {
  AttemptKey key;
  std::filesystem::path folder;
  int threads = 1;
  std::uint64_t memory = 0;           ///< estimate [bytes]
  double checkpoint_interval = 30.0;  ///< [s]
};

enum class Phase : std::uint8_t {
  kUnknown,  ///< no news now: whatever was known still holds
  kWaiting,  ///< accepted; has not begun
  kRunning,
  kEnded,
};

struct AttemptNews {
  AttemptKey key;
  Phase phase = Phase::kUnknown;
  Cause cause = Cause::kNone;         ///< with kEnded
  std::optional<ProcessEnd> process;  ///< with kEnded, if somebody saw it end
  std::string engine_id;              ///< its name in the engine; "" if it has none yet
  std::string place;                  ///< "process 4711"
  std::string words;                  ///< for people: why it waits, what is known of its end
};

enum class StopMode : std::uint8_t {
  kCheckpoint,  ///< asked to write a checkpoint and end
  kNow,         ///< killed
};

class Executor {
 public:
  virtual ~Executor() = default;

  /// Kept with each attempt: "local".
  virtual std::string engine() const = 0;

  /// Whether it takes one more attempt of this estimate [bytes].
  virtual bool has_room(std::uint64_t memory) const = 0;

  /// Ok: it has the attempt. Unavailable: nobody knows whether it has; news will tell, in the end at least
  /// that it never ran. Any other error: it has not, and never will.
  virtual absl::Status start(const AttemptOrder& order) = 0;

  /// Asked to end; news tell when it has. One that is not there any more is none of its business.
  virtual void stop(const AttemptKey& key, StopMode mode) = 0;

  /// How the attempts stand that were started or adopted and not forgotten.
  virtual std::vector<AttemptNews> news() = 0;

  /// The end of this attempt is durable, or of interest to nobody: no more news of it.
  virtual void forget(const AttemptKey& key) = 0;

  /// At the start of the daemon: attempts of the one before, started or perhaps not.
  virtual void adopt(const std::vector<AttemptKey>& keys) = 0;

  /// Whether attempts go on without the daemon. If not, they are stopped with it, and those of a daemon that
  /// was killed are ending by themselves.
  virtual bool survives_daemon() const = 0;

  /// Readable when there may be news.
  virtual int descriptor() const = 0;
};

}  // namespace creepd
