// Which kernels a run uses, and what they compute.
#pragma once

#include <string>

#include "absl/status/statusor.h"
#include "core/dem/kernels.h"

namespace creep {

/// By name; "" takes the widest that this processor has. Error: InvalidArgument.
absl::StatusOr<const Kernels*> kernels_for(const std::string& instruction_set);

/// Identifies the results of this machine's arithmetic: hash of a self-test of all kernels (16 hex digits).
std::string arithmetic_id(const std::string& instruction_set);

/// "portable", "avx2" or "avx512": the widest that the kernels and this processor share, or CREEP_ISA's wish
/// when the caller passes it in.
absl::StatusOr<std::string> choose_instruction_set(const std::string& wish);

}  // namespace creep
