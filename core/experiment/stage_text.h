// A stage in a few words, for people.
#pragma once

#include <string>

#include "core/experiment/experiment.h"

namespace creep {

/// "21.7 MPa", "p = 10 MPa", "q = 9.04 MPa", "q/p = 1.2", "20 % axial strain".
std::string target_text(const Target& target);

/// "oedometric to 21.7 MPa", "creep for 2 d at q = 9.04 MPa".
std::string stage_text(const Stage& stage);

}  // namespace creep
