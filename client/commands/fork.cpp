#include "client/commands/fork.h"

#include <cstdint>
#include <cstdio>
#include <memory>

#include "client/connection.h"
#include "client/exit_codes.h"
#include "client/job_file.h"
#include "client/message_json.h"
#include "client/remote_job.h"

namespace creepctl {
namespace {

struct Options {
  ServerOptions server;
  std::string id;
  std::uint64_t checkpoint = 0;
  std::string job;
  std::vector<std::string> labels;
  int priority = 0;
  std::string request_id;
  bool json = false;
};

int fork(const Options& options) {
  api::ForkJobRequest request;
  set_labels(options.labels, *request.mutable_labels());
  if (!options.job.empty()) {
    const JobFile job = read_job_file(options.job);
    print_diagnostics(job);
    if (!job.experiment) return kInvalidInput;
    request.set_spec(job.text);
  }
  request.set_generation(options.checkpoint);
  request.set_priority(options.priority);
  request.set_request_id(options.request_id.empty() ? new_request_id() : options.request_id);
  return with_connection(options.server, [&](Connection& connection) {
    api::Job source;
    if (const CallResult result = find_job(connection, options.id, source); !result.ok()) {
      print_failure(result);
      return exit_code_of(result);
    }
    request.set_job(source.id());
    api::SubmitJobResponse response;
    if (const CallResult result = connection.call(request, response); !result.ok()) {
      print_failure(result, options.job);
      return exit_code_of(result);
    }
    if (options.json) {
      print_json(to_json(response));
    } else {
      std::printf("%s\n", response.job().id().c_str());
    }
    return kOk;
  });
}

}  // namespace

void add_fork(CLI::App& app, int& exit_code) {
  CLI::App* command = app.add_subcommand("fork", "Makes a new job that begins from a checkpoint of another");
  auto options = std::make_shared<Options>();
  command->add_option("ID", options->id, "The job to begin from, or the beginning of its id")->required();
  command->add_option("--checkpoint", options->checkpoint,
                      "N of checkpoints/ck.N (default: the newest good one)");
  command->add_option("--job", options->job, "A job file instead of the source's");
  command->add_option("--label", options->labels, "KEY=VALUE to find it by; can be given again")
      ->expected(1)
      ->take_all()
      ->type_name("KEY=VALUE");
  command->add_option("--priority", options->priority, "Higher starts first")
      ->check(CLI::Range(-100, 100))
      ->capture_default_str();
  command->add_option("--request-id", options->request_id,
                      "The same again gives the same job, not a second one");
  command->add_flag("--json", options->json, "Print the new job as JSON");
  add_server_options(*command, options->server);
  command->footer(
      "Prints the id of the new job, alone, on stdout. A job file given must not change the experiment.\n\n"
      "Example:\n  creepctl fork 3f2a --checkpoint 12");
  command->callback([options, &exit_code] { exit_code = fork(*options); });
}

}  // namespace creepctl
