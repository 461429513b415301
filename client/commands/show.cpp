#include "client/commands/commands.h"

#include <cstdio>
#include <memory>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "client/remote/connection.h"
#include "client/remote/message_json.h"
#include "client/remote/remote_job.h"
#include "client/terminal/exit_codes.h"
#include "client/terminal/table.h"
#include "client/terminal/terminal.h"
#include "core/experiment/experiment_toml.h"
#include "core/experiment/wording.h"

namespace creepctl {
namespace {

struct Options {
  ServerOptions server;
  std::string id;
  bool spec = false;
  bool attempts = false;
  bool json = false;
};

void line(const char* name, const std::string& value) {
  if (!value.empty()) std::printf("  %-18s %s\n", name, value.c_str());
}

void print_figures(const api::Sample& sample) {
  line("creep time", short_duration(sample.creep_time_s()));
  line("axial stress", absl::StrFormat("%.4g MPa", sample.axial_stress_pa() / 1e6));
  line("axial strain", absl::StrFormat("%.4g %%", 100.0 * sample.axial_strain()));
  line("void ratio", absl::StrFormat("%.4f", sample.void_ratio()));
  line("I_G", absl::StrFormat("%.4f", sample.grading_index()));
  line("broken particles", absl::StrFormat("%d of %d now", sample.broken_total(), sample.particles()));
}

std::string labels_of(const api::Job& job) {
  // A map of protobuf has no order of its own.
  const std::map<std::string, std::string> sorted(job.labels().begin(), job.labels().end());
  std::string text;
  for (const auto& [key, value] : sorted) absl::StrAppend(&text, text.empty() ? "" : " ", key, "=", value);
  return text;
}

void print_text(const api::Job& job) {
  std::printf("%s %s\n", job.id().c_str(), job.name().c_str());
  const std::string state = state_text(job.state(), job.state_reason());
  line("state", job.state() == api::FAILED ? red(state, stdout) : state);
  line("", news_in(job.state_message(), job.state_reason()));
  if (job.queue_position() > 0) line("queue position", absl::StrCat(job.queue_position()));
  if (job.state() == api::RUNNING && job.has_progress()) {
    const creep::ParseResult parsed = creep::parse_experiment(job.spec());
    line("progress", plain_line(run_progress_of(job), parsed.experiment.value_or(creep::Experiment())));
  }
  line("owner", job.owner());
  line("labels", labels_of(job));
  if (job.priority() != 0) line("priority", absl::StrCat(job.priority()));
  line("submitted", instant(job.submit_time().seconds()));
  if (job.has_start_time()) line("started", instant(job.start_time().seconds()));
  if (job.has_end_time()) line("ended", instant(job.end_time().seconds()));
  line("attempts", absl::StrCat(job.attempts()));
  if (!job.parent_job().empty()) {
    line("forked from", absl::StrCat(job.parent_job(), ", checkpoint ", job.parent_generation()));
  }
  if (job.has_latest_sample()) print_figures(job.latest_sample());
  line("state_digest", job.state_digest());
  for (const std::string& warning : job.warnings()) line("warning", warning);
  if (!job.log_tail().empty()) std::printf("The end of worker.log:\n%s\n", job.log_tail().c_str());
}

/// "0", "signal 9", "" while it runs or where nobody saw it.
std::string end_of(const api::Attempt& attempt) {
  if (attempt.has_signal()) return absl::StrCat("signal ", attempt.signal());
  return attempt.has_exit_code() ? absl::StrCat(attempt.exit_code()) : "";
}

std::string state_of(const api::Attempt& attempt) {
  constexpr std::string_view kPrefix = "ATTEMPT_";
  std::string name = api::AttemptState_Name(attempt.state());
  return absl::StartsWith(name, std::string(kPrefix)) ? name.substr(kPrefix.size()) : name;
}

/// Wall time of an attempt that has ended and was seen to begin.
std::string time_of(const api::Attempt& attempt) {
  if (!attempt.has_start_time() || !attempt.has_end_time()) return "";
  const auto seconds = [](const google::protobuf::Timestamp& moment) {
    return static_cast<double>(moment.seconds()) + 1e-9 * moment.nanos();
  };
  return short_duration(seconds(attempt.end_time()) - seconds(attempt.start_time()));
}

int show_attempts(const Options& options, const std::string& id, Connection& connection) {
  std::vector<api::Attempt> attempts;
  if (const CallResult result = list_attempts(connection, id, attempts); !result.ok()) {
    print_failure(result);
    return exit_code_of(result);
  }
  if (options.json) {
    nlohmann::ordered_json list = nlohmann::ordered_json::array();
    for (const api::Attempt& attempt : attempts) list.push_back(to_json(attempt));
    print_json(list);
    return kOk;
  }
  Table table({{"ATTEMPT", Align::kRight},
               {"STATE"},
               {"ASKED FOR"},
               {"RAN FOR", Align::kRight},
               {"ENGINE"},
               {"PLACE"},
               {"EXIT"},
               {"HOW IT ENDED"}});
  for (const api::Attempt& attempt : attempts) {
    table.add({absl::StrCat(attempt.number()), state_of(attempt), instant(attempt.ask_time().seconds()),
               time_of(attempt), attempt.engine(), attempt.place(), end_of(attempt), attempt.message()});
  }
  if (attempts.empty()) std::fprintf(stderr, "no attempts\n");
  if (!attempts.empty())
    std::fputs(table.text(is_terminal(stdout) ? terminal_width(stdout) : 0).c_str(), stdout);
  return kOk;
}

int show(const Options& options, Connection& connection) {
  api::Job job;
  if (const CallResult result = find_job(connection, options.id, job); !result.ok()) {
    print_failure(result);
    return exit_code_of(result);
  }
  if (options.attempts) return show_attempts(options, job.id(), connection);
  if (options.json) {
    print_json(to_json(job));
  } else if (options.spec) {
    const std::string spec = is_terminal(stdout) ? creep::printable_lines(job.spec()) : job.spec();
    std::fwrite(spec.data(), 1, spec.size(), stdout);
  } else {
    print_text(job);
  }
  return kOk;
}

}  // namespace

void add_show(CLI::App& app, int& exit_code) {
  CLI::App* command = app.add_subcommand("show", "Shows a job: state, figures, times, what went wrong");
  auto options = std::make_shared<Options>();
  command->add_option("ID", options->id, "The job, or the beginning of its id")->required();
  command->add_flag("--spec", options->spec, "Print the job file, byte for byte as sent");
  command
      ->add_flag("--attempts", options->attempts,
                 "Print every attempt: when it was asked for, how long it ran and where, how it ended")
      ->excludes("--spec");
  command->add_flag("--json", options->json, "Print JSON");
  add_server_options(*command, options->server);
  command->footer("Example:\n  creepctl show 3f2a --json");
  command->callback([options, &exit_code] {
    exit_code =
        with_connection(options->server, [&](Connection& connection) { return show(*options, connection); });
  });
}

}  // namespace creepctl
