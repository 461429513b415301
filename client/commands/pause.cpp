#include "client/commands/commands.h"

#include <memory>

#include "client/remote/change_jobs.h"

namespace creepctl {
namespace {

struct Options {
  ServerOptions server;
  std::vector<std::string> ids;
};

}  // namespace

void add_pause(CLI::App& app, int& exit_code) {
  CLI::App* command = app.add_subcommand("pause", "Takes jobs off their slots, with a checkpoint");
  auto options = std::make_shared<Options>();
  command->add_option("IDS", options->ids, "The jobs, or the beginnings of their ids")->required();
  add_server_options(*command, options->server);
  command->footer(
      "A running job checkpoints first and is PAUSED within seconds. It keeps its place on disk until "
      "resumed.\n\n"
      "Example:\n  creepctl pause 3f2a");
  command->callback([options, &exit_code] {
    exit_code = change_jobs(options->server, options->ids, api::PauseJobRequest());
  });
}

}  // namespace creepctl
