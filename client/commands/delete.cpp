#include "client/commands/commands.h"

#include <cstdio>
#include <memory>

#include "client/remote/connection.h"
#include "client/remote/remote_job.h"
#include "client/terminal/exit_codes.h"

namespace creepctl {
namespace {

struct Options {
  ServerOptions server;
  std::vector<std::string> ids;
};

int delete_jobs(const Options& options, Connection& connection) {
  std::vector<api::Job> jobs;
  int exit_code = find_jobs(connection, options.ids, jobs);
  if (exit_code != kOk) return exit_code;
  for (const api::Job& job : jobs) {
    api::DeleteJobRequest request;
    request.set_job(job.id());
    api::DeleteJobResponse response;
    const CallResult result = connection.call(request, response);
    // Not there any more: an earlier call did it whose answer was lost.
    if (result.ok() || absl::IsNotFound(result.status)) {
      std::printf("%s: deleted\n", job.id().c_str());
    } else {
      print_failure(result);
      exit_code = exit_code_of(result);
    }
  }
  return exit_code;
}

}  // namespace

void add_delete(CLI::App& app, int& exit_code) {
  CLI::App* command = app.add_subcommand("delete", "Removes ended or paused jobs and all their files");
  auto options = std::make_shared<Options>();
  command->add_option("IDS", options->ids, "The jobs, or the beginnings of their ids")->required();
  add_server_options(*command, options->server);
  command->footer(
      "Cannot be undone. If one of the ids is unknown, nothing is deleted.\n\n"
      "Example:\n  creepctl delete 3f2a 7c01");
  command->callback([options, &exit_code] {
    exit_code = with_connection(options->server,
                                [&](Connection& connection) { return delete_jobs(*options, connection); });
  });
}

}  // namespace creepctl
