// What the program says of itself in all that it writes: summaries, checkpoints, logs, the daemon's answers.
#pragma once

#include <string_view>

namespace creep {

/// "0.2.0": of the newest entry of deploy/debian/changelog.
std::string_view program_version();

}  // namespace creep
