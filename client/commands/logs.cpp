#include "client/commands/commands.h"

#include <chrono>
#include <cstdio>
#include <memory>
#include <thread>

#include "absl/strings/str_cat.h"
#include "client/remote/artifacts.h"
#include "client/remote/connection.h"
#include "client/remote/remote_job.h"
#include "client/terminal/exit_codes.h"
#include "client/terminal/terminal.h"

namespace creepctl {
namespace {

constexpr const char* kLog = "worker.log";

struct Options {
  ServerOptions server;
  std::string id;
  bool follow = false;
};

/// Prints what is new in the log.
CallResult print_log(Connection& connection, const std::string& id, ArtifactPosition& position) {
  CallResult result = read_artifact(
      connection, id, kLog, position, [](const api::Artifact&) { return true; },
      [](std::string_view text) { return std::fwrite(text.data(), 1, text.size(), stdout) == text.size(); });
  std::fflush(stdout);
  if (result.reason == "ARTIFACT_NOT_FOUND") return {};  // not begun yet
  if (result.reason != "ARTIFACT_REPLACED" && result.reason != "OFFSET_BEYOND_END") return result;
  position = {};
  return {};
}

int logs(const Options& options, Connection& connection) {
  api::Job job;
  CallResult result = find_job(connection, options.id, job);
  const std::string id = job.id();
  ArtifactPosition position;
  while (result.ok()) {
    // The state is older than the log that is printed after it, so nothing is missed at the end.
    const bool last = !options.follow || is_final(job.state());
    result = print_log(connection, id, position);
    if (!result.ok() || last) break;
    std::this_thread::sleep_for(std::chrono::seconds(1));
    api::GetJobRequest request;
    request.set_job(id);
    result = connection.call(request, job);
  }
  if (result.ok() && position.etag.empty()) {
    complain(absl::StrCat(id, " has no log: it is ", state_text(job.state(), job.state_reason())));
  }
  if (result.ok()) return kOk;
  print_failure(result);
  return exit_code_of(result);
}

}  // namespace

void add_logs(CLI::App& app, int& exit_code) {
  CLI::App* command = app.add_subcommand("logs", "Prints what the worker of a job logged");
  auto options = std::make_shared<Options>();
  command->add_option("ID", options->id, "The job, or the beginning of its id")->required();
  command->add_flag("--follow,-f", options->follow, "Go on until the job has ended");
  add_server_options(*command, options->server);
  command->footer("Example:\n  creepctl logs -f 3f2a");
  command->callback([options, &exit_code] {
    exit_code =
        with_connection(options->server, [&](Connection& connection) { return logs(*options, connection); });
  });
}

}  // namespace creepctl
