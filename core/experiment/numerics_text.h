// [numerics] as it is carried out: every key with its value, whether a fidelity, the job or a default gave
// it.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "core/experiment/experiment.h"

namespace creep {

struct NumericsValue {
  std::string_view key;  ///< of the job file
  std::string value;     ///< as in a job file: a number, or a string in double quotes
};

/// In the order of experiment.h; what has no value is left out: an n_age of the paper's fraction of the
/// particles, a criterion that is off.
std::vector<NumericsValue> numerics_values(const Numerics& numerics);

/// "minimum_cycles = 1000, time_step_safety = 0.7, ..."
std::string numerics_text(const Numerics& numerics);

}  // namespace creep
