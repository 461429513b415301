// How a run ended.
#pragma once

#include <string>

namespace creep {

/// How a run ended. A creep failure is a result: the job ends well.
struct Outcome {
  enum class Kind { kCompleted, kCreepFailure, kGuardStop };
  Kind kind = Kind::kCompleted;
  std::string reason;  ///< "completed", "creep failure: axial creep strain 0.21 > 0.2", "guard overlap: ..."
  std::string advice;  ///< for a guard stop: what cures it
};

}  // namespace creep
