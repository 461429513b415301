// The last section of checkpoints of formats 1 to 7: one list of fields for a run in any act, where -1 and 0
// stood for "not yet".
#pragma once

#include <cstdint>

#include "core/state/archive.h"
#include "core/state/state.h"

namespace creep {

/// Reads the section into all of the state beside its specimen. False for one that stands nowhere in a
/// program.
bool read_format_7(Reader& reader, std::uint64_t version, RunState& state);

}  // namespace creep
