// A stage in a few words, for people.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>

#include "core/experiment/experiment.h"

namespace creep {

/// "21.7 MPa", "p = 10 MPa", "q = 9.04 MPa", "q/p = 1.2", "20 % axial strain".
std::string target_text(const Target& target);

/// "oedometric to 21.7 MPa", "creep for 2 d at q = 9.04 MPa".
std::string stage_text(const Stage& stage);

/// Name of a checkpoint that a stage keeps, `place` being its own in the program from 0: of its end,
/// "02_triaxial_end", or of a multiple of the step of `keep`, "02_triaxial_deviatoric_stress_4.52MPa".
std::string kept_checkpoint_name(std::size_t place, const Stage& stage, std::optional<std::int64_t> multiple);

}  // namespace creep
