// The wall clock of the daemon.
#pragma once

#include <chrono>

#include "server/rules/job.h"

namespace creepd {

inline Moment wall_clock() {
  return std::chrono::duration_cast<std::chrono::microseconds>(
             std::chrono::system_clock::now().time_since_epoch())
      .count();
}

}  // namespace creepd
