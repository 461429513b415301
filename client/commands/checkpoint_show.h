// creepctl checkpoint show FILE|DIR
#pragma once

#include <CLI/CLI.hpp>

namespace creepctl {

/// Adds `checkpoint` with its command `show` to `app`. The callback sets `exit_code`, which must outlive the
/// parse.
void add_checkpoint(CLI::App& app, int& exit_code);

}  // namespace creepctl
