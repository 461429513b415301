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

void add_resume(CLI::App& app, int& exit_code) {
  CLI::App* command = app.add_subcommand("resume", "Puts paused jobs back into the queue");
  auto options = std::make_shared<Options>();
  command->add_option("IDS", options->ids, "The jobs, or the beginnings of their ids")->required();
  add_server_options(*command, options->server);
  command->footer(
      "A job continues from its newest good checkpoint, to the same bits as without the pause.\n\n"
      "Example:\n  creepctl resume 3f2a");
  command->callback([options, &exit_code] {
    exit_code = change_jobs(options->server, options->ids, api::ResumeJobRequest());
  });
}

}  // namespace creepctl
