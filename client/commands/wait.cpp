#include "client/commands/commands.h"

#include <memory>

#include "absl/strings/str_cat.h"
#include "client/remote/connection.h"
#include "client/remote/follow.h"
#include "client/remote/remote_job.h"
#include "client/terminal/exit_codes.h"
#include "client/terminal/terminal.h"
#include "core/experiment/units.h"

namespace creepctl {
namespace {

struct Options {
  ServerOptions server;
  std::string id;
  std::string timeout;  // with its unit
  bool quiet = false;
};

/// [s]. A bare number of seconds gets its unit.
absl::StatusOr<double> parse_timeout(std::string& text) {
  if (!text.empty() && text.find_first_not_of("-0123456789.") == std::string::npos) text += " s";
  const auto seconds = creep::parse_quantity(text, creep::Dimension::kDuration);
  if (seconds.ok() && *seconds < 0.0) return absl::InvalidArgumentError(text + " is negative");
  return seconds;
}

FollowListener patient_listener() {
  FollowListener listener;
  listener.lost = [](const std::string& why) {
    complain(absl::StrCat("the daemon went away (", why, "), waiting for it"));
  };
  listener.again = [](double) { complain("the daemon is back"); };
  return listener;
}

int wait(const Options& options, Connection::Deadline deadline, Connection& connection) {
  api::Job job;
  if (const CallResult result = find_job(connection, options.id, job); !result.ok()) {
    print_failure(result);
    return exit_code_of(result);
  }
  connection.set_patience(std::chrono::seconds(0));  // follow() has its own
  FollowEnd end{FollowEnd::kFinal, job.state(), {}};
  if (!is_final(job.state()))
    end = follow(connection, job.id(), job.last_seq(), deadline, patient_listener());
  if (end.kind == FollowEnd::kTimedOut) {
    complain(absl::StrCat(job.id(), " has not ended within ", options.timeout));
    return kWaitTimedOut;
  }
  if (end.kind == FollowEnd::kRefused) {
    print_failure(end.refusal);
    return exit_code_of(end.refusal);
  }
  if (!options.quiet) std::printf("%s: %s\n", job.id().c_str(), api::JobState_Name(end.state).c_str());
  return exit_code_of(end.state);
}

}  // namespace

void add_wait(CLI::App& app, int& exit_code) {
  CLI::App* command = app.add_subcommand("wait", "Returns when a job has ended");
  auto options = std::make_shared<Options>();
  command->add_option("ID", options->id, "The job, or the beginning of its id")->required();
  command->add_option("--timeout", options->timeout, "Give up after so long, e.g. \"90 s\" or \"2 h\"");
  command->add_flag("--quiet,-q", options->quiet, "Print nothing, only return the exit code");
  add_server_options(*command, options->server);
  command->footer(
      "Exit code 0: succeeded; 1: failed; 3: cancelled; 4: no daemon; 5: no such job; 6: timed out.\n\n"
      "Example:\n  creepctl wait 3f2a --timeout \"2 d\" && creepctl fetch 3f2a --out creep-2d");
  command->callback([options, &exit_code] {
    Connection::Deadline deadline;
    if (!options->timeout.empty()) {
      const auto seconds = parse_timeout(options->timeout);
      if (!seconds.ok()) throw CLI::ValidationError("--timeout", std::string(seconds.status().message()));
      deadline =
          std::chrono::system_clock::now() + std::chrono::duration_cast<std::chrono::system_clock::duration>(
                                                 std::chrono::duration<double>(*seconds));
    }
    exit_code = with_connection(options->server,
                                [&](Connection& connection) { return wait(*options, deadline, connection); });
  });
}

}  // namespace creepctl
