// creepctl: one file a command under client/commands; here they are only listed.
#include <CLI/CLI.hpp>

#include "client/commands/version.h"
#include "client/exit_codes.h"

int main(int argument_count, char** arguments) {
  CLI::App app{"Simulates creep in quartz sands: checks, runs and reports jobs.", "creepctl"};
  app.require_subcommand(1);
  app.footer("'creepctl COMMAND --help' explains a command.\n\nExample:\n  creepctl version");

  int exit_code = creepctl::kOk;
  creepctl::add_version(app, exit_code);

  try {
    app.parse(argument_count, arguments);
  } catch (const CLI::ParseError& error) {
    // CLI11 gives 0 for --help and a number of its own for each usage error; ours has one.
    return app.exit(error) == 0 ? creepctl::kOk : creepctl::kUsage;
  }
  return exit_code;
}
