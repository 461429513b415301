#include "client/commands/commands.h"

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
  std::string job;
  std::vector<std::string> changes;
  std::vector<std::string> labels;
  int priority = 0;
  std::string request_id;
  bool validate_only = false;
  bool json = false;
};

int submit(const Options& options) {
  api::SubmitJobRequest request;
  set_labels(options.labels, *request.mutable_labels());
  const auto overrides = parse_overrides(options.changes);
  if (!overrides.ok()) {
    complain(std::string(overrides.status().message()));
    return kUsage;
  }
  // Set here, not by the daemon: one of before would pass over them.
  const JobFile job = read_job_file(options.job, *overrides);
  print_diagnostics(job);
  if (!job.experiment) return kInvalidInput;
  request.set_spec(job.text);
  request.set_priority(options.priority);
  request.set_validate_only(options.validate_only);
  // With one, a call whose answer was lost can be repeated without making a second job.
  request.set_request_id(options.request_id.empty() ? new_request_id() : options.request_id);
  return with_connection(options.server, [&](Connection& connection) {
    api::SubmitJobResponse response;
    if (const CallResult result = connection.call(request, response); !result.ok()) {
      print_failure(result, options.job);
      return exit_code_of(result);
    }
    if (options.json) {
      print_json(to_json(response));
    } else if (options.validate_only) {
      std::printf("%s: would be taken, needs %.0f MiB\n", options.job.c_str(),
                  static_cast<double>(response.job().memory_estimate_bytes()) / 1048576.0);
    } else {
      std::printf("%s\n", response.job().id().c_str());
      if (response.already_existed()) std::fprintf(stderr, "submitted before with this request id\n");
    }
    return kOk;
  });
}

}  // namespace

void add_submit(CLI::App& app, int& exit_code) {
  CLI::App* command = app.add_subcommand("submit", "Puts a job into the daemon's queue");
  auto options = std::make_shared<Options>();
  command->add_option("JOB", options->job, "The job file")->required();
  command
      ->add_option(
          "--set", options->changes,
          "KEY=VALUE of the job file, like specimen.seed=7 or program.0.duration=\"2 d\"; can be given "
          "again. The job's file is the text with them, its comments are lost")
      ->expected(1)
      ->take_all()
      ->type_name("KEY=VALUE");
  command->add_option("--label", options->labels, "KEY=VALUE to find it by; can be given again")
      ->expected(1)
      ->take_all()
      ->type_name("KEY=VALUE");
  command->add_option("--priority", options->priority, "Higher starts first")
      ->check(CLI::Range(-100, 100))
      ->capture_default_str();
  command->add_option("--request-id", options->request_id,
                      "The same again gives the same job, not a second one");
  command->add_flag("--validate-only", options->validate_only, "Have the daemon check it, make no job");
  command->add_flag("--json", options->json, "Print the job as JSON");
  add_server_options(*command, options->server);
  command->footer(
      "Prints the id of the job, alone, on stdout.\n"
      "Exit code 0: queued, and safe there; 1: the daemon has no room; 4: no daemon; 5: wrong job file.\n\n"
      "Example:\n  id=$(creepctl submit creep.toml --label sand=NE34)");
  command->callback([options, &exit_code] { exit_code = submit(*options); });
}

}  // namespace creepctl
