#include "client/commands/commands.h"

#include <chrono>
#include <cstdio>
#include <memory>

#include "absl/strings/ascii.h"
#include "absl/strings/str_format.h"
#include "client/remote/connection.h"
#include "client/remote/message_json.h"
#include "client/remote/remote_job.h"
#include "client/terminal/exit_codes.h"
#include "client/terminal/table.h"
#include "client/terminal/terminal.h"

namespace creepctl {
namespace {

const std::vector<std::string> kStates = {"queued", "running", "paused", "succeeded", "failed", "cancelled"};

struct Options {
  ServerOptions server;
  std::vector<std::string> states;
  std::vector<std::string> labels;
  std::size_t limit = 0;
  bool quiet = false;
  bool json = false;
};

std::string age_of(std::int64_t seconds) {
  const auto now = std::chrono::system_clock::now().time_since_epoch();
  const auto age = std::chrono::duration_cast<std::chrono::seconds>(now).count() - seconds;
  return short_duration(static_cast<double>(std::max<std::int64_t>(age, 0))) + " ago";
}

/// "#3 in the queue", "creep 62 %"
std::string place_of(const api::Job& job) {
  if (job.state() == api::QUEUED && job.queue_position() > 0) {
    return absl::StrFormat("#%d in the queue", job.queue_position());
  }
  if (is_final(job.state()) || !job.has_progress()) return "";
  return absl::StrFormat("%s %.0f %%", job.progress().stage(), 100.0 * job.progress().stage_fraction());
}

Table table_of(const std::vector<api::Job>& jobs) {
  Table table({{"ID"},
               {"STATE"},
               {"STAGE"},
               {"CREEP TIME", Align::kRight},
               {"STRAIN", Align::kRight},
               {"I_G", Align::kRight},
               {"SUBMITTED"},
               {"NAME"}});
  for (const api::Job& job : jobs) {
    const api::Sample& sample = job.latest_sample();
    const bool measured = job.has_latest_sample();
    table.add({job.id(), state_text(job.state(), job.state_reason()), place_of(job),
               measured ? short_duration(sample.creep_time_s()) : "",
               measured ? absl::StrFormat("%.3g %%", 100.0 * sample.axial_strain()) : "",
               measured ? absl::StrFormat("%.4f", sample.grading_index()) : "",
               age_of(job.submit_time().seconds()), job.name()});
  }
  return table;
}

int ls(const Options& options) {
  api::ListJobsRequest request;
  set_labels(options.labels, *request.mutable_labels());
  for (const std::string& name : options.states) {
    api::JobState state = api::JOB_STATE_UNSPECIFIED;
    api::JobState_Parse(absl::AsciiStrToUpper(name), &state);
    request.add_states(state);
  }
  return with_connection(options.server, [&](Connection& connection) {
    std::vector<api::Job> jobs;
    if (const CallResult result = list_jobs(connection, request, options.limit, jobs); !result.ok()) {
      print_failure(result);
      return exit_code_of(result);
    }
    if (options.json) {
      nlohmann::ordered_json list = nlohmann::ordered_json::array();
      for (const api::Job& job : jobs) list.push_back(to_json(job));
      print_json(list);
    } else if (options.quiet) {
      for (const api::Job& job : jobs) std::printf("%s\n", job.id().c_str());
    } else if (jobs.empty()) {
      std::fprintf(stderr, "no jobs\n");
    } else {
      const int width = is_terminal(stdout) ? terminal_width(stdout) : 0;
      std::fputs(table_of(jobs).text(width).c_str(), stdout);
    }
    return kOk;
  });
}

}  // namespace

void add_ls(CLI::App& app, int& exit_code) {
  CLI::App* command = app.add_subcommand("ls", "Lists your jobs, the newest first");
  auto options = std::make_shared<Options>();
  command->add_option("--state", options->states, "Only these")
      ->delimiter(',')
      ->check(CLI::IsMember(kStates, CLI::ignore_case));
  command->add_option("--label", options->labels, "Only jobs with KEY=VALUE; can be given again")
      ->expected(1)
      ->take_all()
      ->type_name("KEY=VALUE");
  command->add_option("--limit", options->limit, "At most so many (default: all)")
      ->check(CLI::Range(1, 1000000));
  command->add_flag("--quiet,-q", options->quiet, "Only the ids");
  command->add_flag("--json", options->json, "Print JSON");
  add_server_options(*command, options->server);
  command->footer("Example:\n  creepctl ls --state running,queued --label sand=NE34");
  command->callback([options, &exit_code] { exit_code = ls(*options); });
}

}  // namespace creepctl
