// creepctl completion SHELL
#pragma once

#include <CLI/CLI.hpp>

namespace creepctl {

/// Adds the command to `app`, whose tree the script is made of. Its callback sets `exit_code`, which must
/// outlive the parse.
void add_completion(CLI::App& app, int& exit_code);

}  // namespace creepctl
