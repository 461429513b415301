// creepctl sweep JOB
#pragma once

#include <CLI/CLI.hpp>

namespace creepctl {

/// Adds the command to `app`. Its callback sets `exit_code`, which must outlive the parse.
void add_sweep(CLI::App& app, int& exit_code);

}  // namespace creepctl
