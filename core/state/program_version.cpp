#include "core/state/program_version.h"

namespace creep {

std::string_view program_version() { return CREEP_VERSION; }

}  // namespace creep
