// The jobs of a sweep on a daemon, each submitted once however often this is called.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "client/remote/connection.h"
#include "client/sweep/sweep_end.h"
#include "client/sweep/sweep_plan.h"

namespace creepctl {

struct RemoteSweepOptions {
  std::string name;  ///< of the sweep: label `sweep` of its jobs, and part of their request ids
  std::vector<std::string> labels;
  int priority = 0;
  bool wait = true;  ///< until all have ended; else only what can be submitted now is
  int poll_seconds = 2;
};

/// Submits trunks and jobs without one; forks each branch once its trunk keeps the checkpoint. Each job has
/// the labels sweep=NAME and member=NAME OF THE JOB. A daemon that goes away is waited for. A job that is
/// refused, fails or is cancelled stops no other. `say` is told in a line what changes. Error: of the first
/// call, e.g. that there is no daemon.
CallResult sweep_remotely(Connection& connection, const std::vector<SweepJob>& jobs,
                          const RemoteSweepOptions& options,
                          const std::function<void(const std::string&)>& say, std::vector<SweepEnd>& ends);

}  // namespace creepctl
