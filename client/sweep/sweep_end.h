// How far the jobs of a sweep came.
#pragma once

#include <string>
#include <vector>

#include "client/terminal/exit_codes.h"

namespace creepctl {

struct SweepEnd {
  std::string name;     ///< of the job in the plan
  std::string place;    ///< its folder or its id; "" if it has none yet
  bool ended = false;   ///< for good or bad; else it waits or was stopped
  int exit_code = kOk;  ///< what `run` or `wait` would return; kRunAgain if it has not ended
  std::string message;  ///< a sentence: the outcome, or why not
};

/// 0 if all are done; else 1 for a failed one, 5, 74, 3 for a cancelled one, 75 if some have not ended: the
/// first of these that there is.
int exit_code_of(const std::vector<SweepEnd>& ends);

/// Every job that is not done with the reason, and how many are: a table with no more lines than needed.
std::string summary_text(const std::vector<SweepEnd>& ends, int width);

/// The same of all, as JSON.
std::string summary_json(const std::vector<SweepEnd>& ends);

}  // namespace creepctl
