#include "client/commands/commands.h"

#include <charconv>
#include <cstdint>
#include <cstdio>
#include <memory>

#include "client/job_file/job_file.h"
#include "client/remote/connection.h"
#include "client/remote/message_json.h"
#include "client/remote/remote_job.h"
#include "client/terminal/exit_codes.h"
#include "client/terminal/terminal.h"

namespace creepctl {
namespace {

struct Options {
  ServerOptions server;
  std::string id;
  std::string checkpoint;
  std::vector<std::string> changes;
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
  std::uint64_t generation = 0;
  const char* const end = options.checkpoint.data() + options.checkpoint.size();
  const auto number = std::from_chars(options.checkpoint.data(), end, generation);
  if (number.ec == std::errc() && number.ptr == end) {
    request.set_generation(generation);
  } else {
    request.set_checkpoint(options.checkpoint);
  }
  const auto overrides = parse_overrides(options.changes);
  if (!overrides.ok()) {
    complain(std::string(overrides.status().message()));
    return kUsage;
  }
  for (const auto& [key, value] : *overrides) (*request.mutable_overrides())[key] = value;
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
                      "N of checkpoints/ck.N, or the name of a kept one, like 02_triaxial_end (default: the "
                      "newest good ck.N)");
  command
      ->add_option("--set", options->changes,
                   "KEY=VALUE of the job file, like program.0.duration=\"2 d\"; can be given again")
      ->expected(1)
      ->take_all()
      ->type_name("KEY=VALUE");
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
      "Prints the id of the new job, alone, on stdout. Without changes the job goes on from the checkpoint, "
      "its\n"
      "records with it; with --set or --job another program starts with the specimen as it stands there.\n\n"
      "Example:\n"
      "  creepctl fork 3f2a --checkpoint 02_triaxial_end \\\n"
      "    --set 'program=[{ stage = \"creep\", q_ratio = 0.4, q_max = \"22.6 MPa\", duration = \"1 d\" }]'");
  command->callback([options, &exit_code] { exit_code = fork(*options); });
}

}  // namespace creepctl
