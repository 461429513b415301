// Following a job by sequence number, through broken connections and restarts of the daemon.
#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include "client/remote/connection.h"

namespace creepctl {

/// What a follower is told; any may be empty.
struct FollowListener {
  std::function<void(const api::Event&)> event;      ///< each sequence number once, rising
  std::function<void(const api::Event&)> heartbeat;  ///< no news, but the daemon is there
  std::function<void(const std::string&)> lost;      ///< the connection broke: why
  std::function<void(double seconds)> again;         ///< it is back, after so long [s]
  bool every_sample = false;                         ///< else live ones are thinned
};

struct FollowEnd {
  enum Kind {
    kFinal,     ///< the job is in a final state
    kTimedOut,  ///< the deadline passed
    kRefused,   ///< see `refusal`
  };
  Kind kind = kFinal;
  api::JobState state = api::JOB_STATE_UNSPECIFIED;  ///< with kFinal
  CallResult refusal;
};

/// Returns when the job is final or the deadline passes. A connection that breaks is made again without end,
/// so the connection's own patience should be zero.
FollowEnd follow(Connection& connection, const std::string& id, std::uint64_t after_seq,
                 Connection::Deadline deadline, const FollowListener& listener);

/// Milliseconds to wait before attempt `attempt` (0, 1, ...) to connect again: doubling from 200 to 5000,
/// less a random part given from 0 to 1, so that many watchers do not come back at once.
int reconnect_delay(int attempt, double random);

}  // namespace creepctl
