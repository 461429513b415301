// The targets of stages: what loading goes until, the deviatoric stress of a hold, what checkpoints are kept.
#pragma once

#include <optional>
#include <span>

#include "core/experiment/experiment.h"
#include "core/experiment/table_reader.h"

namespace creep {

inline constexpr double kLeastStress = 1e3;    // [Pa]
inline constexpr double kLargestStress = 1e9;  // [Pa]

/// `until = { ... }` of a stage with exactly one of the measures given; a deviatoric stress also as q_ratio
/// of q_max. `example` is shown where there is none.
std::optional<Target> read_until(TableReader& stage, std::span<const Target::Measure> measures,
                                 std::string_view example, DiagnosticLog& log);

/// deviatoric_stress, or q_ratio with q_max, of the table [Pa]; none if neither is there or good. At least
/// `least`.
std::optional<double> read_deviatoric_stress(TableReader& table, double least);

/// `keep = {}` or `keep = { every_... = ... }` of a loading stage, or of a hold, which keeps its end only.
std::optional<Keep> read_keep(TableReader& stage, bool loading, DiagnosticLog& log);

}  // namespace creep
