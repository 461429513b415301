// creepctl: one file a command under client/commands; here they are only listed.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <string>
#include <string_view>
#include <vector>

#include "client/commands/commands.h"
#include "client/terminal/exit_codes.h"
#include "core/experiment/wording.h"
#include "core/state/program_version.h"

namespace {

std::vector<std::string> command_names(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::App* command : app.get_subcommands([](const CLI::App*) { return true; })) {
    names.push_back(command->get_name());
  }
  return names;
}

/// CLI11 only says that a command is missing when the one given is unknown.
void print_unknown_command(const std::string& given, const std::vector<std::string>& names) {
  const std::vector<std::string_view> commands(names.begin(), names.end());
  const std::string rest = creep::guess_or_list(given, commands);
  std::fprintf(stderr, "creepctl: unknown command %s%s\n", creep::quoted(given).c_str(), rest.c_str());
}

/// The innermost command that was given, `app` itself if none was.
const CLI::App& given_command(const CLI::App& app) {
  const auto commands = app.get_subcommands();
  return commands.empty() ? app : given_command(*commands.front());
}

/// The first of the arguments left over that is meant as an option, with the option that comes nearest. False
/// if there is none.
bool print_unknown_option(const CLI::App& command) {
  for (const std::string& argument : command.remaining()) {
    if (!argument.starts_with("--")) continue;
    const std::string given = argument.substr(2, argument.find('=') - 2);
    std::vector<std::string_view> names;
    for (const CLI::Option* option : command.get_options()) {
      names.insert(names.end(), option->get_lnames().begin(), option->get_lnames().end());
    }
    const auto guess = creep::closest(given, names);
    std::fprintf(stderr, "creepctl: %s has no option --%s%s\n", command.get_name().c_str(),
                 creep::printable(given).c_str(),
                 guess ? ("; did you mean --" + std::string(*guess) + "?").c_str() : "");
    return true;
  }
  return false;
}

}  // namespace

int main(int argument_count, char** arguments) {
  CLI::App app{"Simulates creep in quartz sands: checks, runs and reports jobs.", "creepctl"};
  app.require_subcommand(1);
  app.set_version_flag("--version", "creepctl " + std::string(creep::program_version()));
  app.footer(
      "'creepctl COMMAND --help' explains a command.\n\nExample:\n  creepctl init creep.toml && creepctl "
      "validate creep.toml");

  int exit_code = creepctl::kOk;
  creepctl::add_cancel(app, exit_code);
  creepctl::add_checkpoint(app, exit_code);
  creepctl::add_compare(app, exit_code);
  creepctl::add_completion(app, exit_code);
  creepctl::add_delete(app, exit_code);
  creepctl::add_doctor(app, exit_code);
  creepctl::add_fetch(app, exit_code);
  creepctl::add_fork(app, exit_code);
  creepctl::add_init(app, exit_code);
  creepctl::add_logs(app, exit_code);
  creepctl::add_ls(app, exit_code);
  creepctl::add_pause(app, exit_code);
  creepctl::add_plan(app, exit_code);
  creepctl::add_plot(app, exit_code);
  creepctl::add_report(app, exit_code);
  creepctl::add_resume(app, exit_code);
  creepctl::add_run(app, exit_code);
  creepctl::add_show(app, exit_code);
  creepctl::add_submit(app, exit_code);
  creepctl::add_sweep(app, exit_code);
  creepctl::add_validate(app, exit_code);
  creepctl::add_version(app, exit_code);
  creepctl::add_wait(app, exit_code);
  creepctl::add_watch(app, exit_code);

  try {
    app.parse(argument_count, arguments);
  } catch (const CLI::ParseError& error) {
    const std::string first = argument_count > 1 ? arguments[1] : "-";
    const std::vector<std::string> names = command_names(app);
    if (!first.starts_with('-') && std::find(names.begin(), names.end(), first) == names.end()) {
      print_unknown_command(first, names);
      return creepctl::kUsage;
    }
    if (error.get_exit_code() != 0 && print_unknown_option(given_command(app))) return creepctl::kUsage;
    // CLI11 gives 0 for --help and a number of its own for each usage error; ours has one.
    return app.exit(error) == 0 ? creepctl::kOk : creepctl::kUsage;
  }
  return exit_code;
}
