// The plan of a job for a daemon: the pilot runs there.
#pragma once

#include <functional>
#include <string>

#include "client/remote/connection.h"
#include "core/plan/plan.h"

namespace creepctl {

struct RemotePlan {
  creep::Plan plan;
  creep::Pilot pilot;  ///< of its stages only how many there were
  int threads = 0;     ///< of a worker there
};

/// Has the pilot run, waits for it and deletes it. `say` is told in a line how far it is.
CallResult plan_remotely(Connection& connection, const std::string& spec,
                         const std::function<void(const std::string&)>& say, RemotePlan& plan);

}  // namespace creepctl
