#include "client/commands/commands.h"

#include <chrono>
#include <cstdint>
#include <cstdio>
#include <memory>
#include <optional>

#include "absl/strings/str_cat.h"
#include "client/remote/connection.h"
#include "client/remote/follow.h"
#include "client/remote/message_json.h"
#include "client/remote/remote_job.h"
#include "client/terminal/exit_codes.h"
#include "client/terminal/progress_display.h"
#include "client/terminal/terminal.h"
#include "core/experiment/experiment_toml.h"

namespace creepctl {
namespace {

using Clock = std::chrono::steady_clock;

struct Options {
  ServerOptions server;
  std::string id;
  std::optional<std::uint64_t> after;
  bool json = false;
};

/// One job as it is watched, in words or as JSON lines.
class Watcher {
 public:
  Watcher(Connection& connection, api::Job job, bool json)
      : connection_(connection),
        job_(std::move(job)),
        experiment_(creep::parse_experiment(job_.spec()).experiment.value_or(creep::Experiment())),
        display_(stdout, experiment_),
        json_(json) {}

  FollowEnd run(std::uint64_t after_seq) {
    if (!json_) say_state(job_.state(), job_.state_reason(), job_.state_message());
    const FollowListener listener = {
        .event = [this](const api::Event& event) { on_event(event); },
        .heartbeat = [this](const api::Event& event) { on_heartbeat(event); },
        .lost =
            [this](const std::string& why) {
              display_.warn(absl::StrCat("lost the daemon (", why, "); reconnecting until it is back"));
            },
        .again =
            [this](double seconds) { display_.warn("connected again after " + short_duration(seconds)); },
        .every_sample = json_};
    FollowEnd end = follow(connection_, job_.id(), after_seq, std::nullopt, listener);
    display_.finish();
    return end;
  }

 private:
  void on_event(const api::Event& event) {
    if (json_) {
      print_json_line(to_json(event));
    } else if (event.has_state_change()) {
      const api::StateChange& change = event.state_change();
      job_.set_state(change.state());
      if (is_final(change.state())) refresh(true);
      say_state(change.state(), change.state_reason(), change.message());
    } else if (event.has_sample()) {
      *job_.mutable_latest_sample() = event.sample();
      refresh(false);
    }
  }

  void on_heartbeat(const api::Event& event) {
    if (json_ || !event.heartbeat().has_progress()) return;
    *job_.mutable_progress() = event.heartbeat().progress();
    if (job_.state() == api::RUNNING) display_.show(run_progress_of(job_), false);
  }

  /// Samples can come by the hundred; the speed and the time left change once a second at most.
  void refresh(bool at_the_end) {
    const auto now = Clock::now();
    if (!at_the_end && now - refreshed_ < std::chrono::seconds(1)) return;
    refreshed_ = now;
    api::GetJobRequest request;
    request.set_job(job_.id());
    api::Job job;
    if (connection_.call(request, job).ok()) {
      *job_.mutable_progress() = job.progress();
      *job_.mutable_warnings() = job.warnings();
      if (at_the_end && job.has_latest_sample()) *job_.mutable_latest_sample() = job.latest_sample();
    }
    if (job_.has_progress()) display_.show(run_progress_of(job_), at_the_end);
  }

  void say_state(api::JobState state, api::StateReason reason, const std::string& message) {
    const std::string news = news_in(message, reason);
    const std::string text = absl::StrCat(state_text(state, reason), news.empty() ? "" : ": ", news);
    if (text == said_) return;
    said_ = text;
    display_.say(job_.id() + ": " + text);
  }

  Connection& connection_;
  api::Job job_;
  creep::Experiment experiment_;
  ProgressDisplay display_;
  bool json_;
  Clock::time_point refreshed_{};
  std::string said_;
};

int watch(const Options& options, Connection& connection) {
  api::Job job;
  if (const CallResult result = find_job(connection, options.id, job); !result.ok()) {
    print_failure(result);
    return exit_code_of(result);
  }
  connection.set_patience(std::chrono::seconds(0));  // follow() has its own
  const std::string id = job.id();
  const std::uint64_t after_seq = options.after.value_or(job.last_seq());
  if (is_final(job.state()) && !options.after) {
    if (!options.json) {
      std::printf("%s: %s\n", id.c_str(), state_text(job.state(), job.state_reason()).c_str());
    }
    return exit_code_of(job.state());
  }
  const FollowEnd end = Watcher(connection, std::move(job), options.json).run(after_seq);
  if (end.kind == FollowEnd::kRefused) {
    print_failure(end.refusal);
    return exit_code_of(end.refusal);
  }
  if (!options.json && end.state == api::SUCCEEDED) {
    std::printf("Next: creepctl fetch %s --out DIR\n", id.c_str());
  }
  return exit_code_of(end.state);
}

}  // namespace

void add_watch(CLI::App& app, int& exit_code) {
  CLI::App* command = app.add_subcommand("watch", "Follows a job until it ends");
  auto options = std::make_shared<Options>();
  command->add_option("ID", options->id, "The job, or the beginning of its id")->required();
  command
      ->add_option("--after", options->after,
                   "Begin after this sequence number, 0: from the first event (default: what is new)")
      ->check(CLI::Range(std::int64_t{0}, std::int64_t{1} << 50));
  command->add_flag("--json", options->json, "Print every event as a line of JSON");
  add_server_options(*command, options->server);
  command->footer(
      "A broken connection or a restart of the daemon is waited out, without a gap or a repeat. Ctrl-C ends\n"
      "only the watching.\n"
      "Exit code 0: succeeded; 1: failed; 3: cancelled; 4: no daemon; 5: no such job.\n\n"
      "Example:\n  creepctl watch 3f2a");
  command->callback([options, &exit_code] {
    exit_code =
        with_connection(options->server, [&](Connection& connection) { return watch(*options, connection); });
  });
}

}  // namespace creepctl
