// The named materials and gradings that a job file can start from.
#pragma once

#include <span>
#include <string_view>

#include "core/experiment/experiment.h"

namespace creep {

/// "fontainebleau-ne34" (k = 0.25, d0 = 2 mm), "fontainebleau-ne34-literal" (k = 1/12, d0 = 2 mm).
std::span<const std::string_view> material_preset_names();

/// The material of material_preset_names()[index].
Material material_preset(std::size_t index);

/// "fontainebleau-ne34": lognormal by mass, d50 0.21 mm, cut at 0.1 and 0.4 mm.
std::span<const std::string_view> grading_preset_names();

/// The grading of grading_preset_names()[index].
Grading grading_preset(std::size_t index);

}  // namespace creep
