// The commented job file that init writes.
#pragma once

#include <string>
#include <string_view>

namespace creepctl {

/// A valid job file. Every key is there; those that have a default stand behind "# " with it, so that taking
/// the
/// "# " away keeps the file valid and the experiment the same (side and points apart: they replace another
/// key).
std::string job_template(std::string_view material_preset);

}  // namespace creepctl
