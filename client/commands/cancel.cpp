#include "client/commands/commands.h"

#include <memory>

#include "client/remote/change_jobs.h"

namespace creepctl {
namespace {

struct Options {
  ServerOptions server;
  std::vector<std::string> ids;
  bool now = false;
};

}  // namespace

void add_cancel(CLI::App& app, int& exit_code) {
  CLI::App* command = app.add_subcommand("cancel", "Ends jobs for good; their files stay");
  auto options = std::make_shared<Options>();
  command->add_option("IDS", options->ids, "The jobs, or the beginnings of their ids")->required();
  command->add_flag("--now", options->now,
                    "Kill the worker; else it writes a checkpoint, from which can be forked");
  add_server_options(*command, options->server);
  command->footer(
      "A running job is CANCELLED within seconds. 'creepctl delete' removes its files.\n\n"
      "Example:\n  creepctl cancel 3f2a");
  command->callback([options, &exit_code] {
    api::CancelJobRequest request;
    request.set_mode(options->now ? api::CancelJobRequest::NOW : api::CancelJobRequest::CHECKPOINT);
    exit_code = change_jobs(options->server, options->ids, request);
  });
}

}  // namespace creepctl
