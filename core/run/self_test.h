// Which kernels a run uses.
#pragma once

#include <string>

#include "absl/status/statusor.h"
#include "core/dem/kernels.h"

namespace creep {

/// By name; "" takes the widest that this processor has. Error: InvalidArgument.
absl::StatusOr<const Kernels*> kernels_for(const std::string& instruction_set);

}  // namespace creep
