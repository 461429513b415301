#include "client/commands/commands.h"

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <thread>

#include "absl/strings/str_cat.h"
#include "client/job_file/job_file.h"
#include "client/remote/artifacts.h"
#include "client/remote/connection.h"
#include "client/remote/remote_job.h"
#include "client/sweep/local_sweep.h"
#include "client/sweep/remote_sweep.h"
#include "client/sweep/sweep_plan.h"
#include "client/terminal/exit_codes.h"
#include "client/terminal/terminal.h"

namespace creepctl {
namespace {

struct Options {
  ServerOptions server;
  std::string job;
  std::string seeds, stress_ratios, q_max;
  std::vector<std::string> varied;
  std::string out;
  int at_once = 0;  ///< 0: as many as the processors take
  int threads = 1;
  std::string name;
  std::string fetch;
  std::vector<std::string> labels;
  int priority = 0;
  bool no_wait = false;
  bool dry_run = false;
  bool json = false;
};

/// Usage errors are thrown before anything is read.
SweepRequest request_of(const Options& options) {
  const auto check = [](const char* option, const absl::Status& status) {
    if (!status.ok()) throw CLI::ValidationError(option, std::string(status.message()));
  };
  SweepRequest request;
  if (!options.seeds.empty()) {
    auto seeds = parse_seeds(options.seeds);
    check("--seeds", seeds.status());
    request.seeds = *std::move(seeds);
  }
  if (!options.stress_ratios.empty()) {
    auto ratios = parse_stress_ratios(options.stress_ratios);
    check("--stress-ratio", ratios.status());
    request.stress_ratios = *std::move(ratios);
  }
  for (const std::string& text : options.varied) {
    auto varied = parse_varied_key(text);
    check("--set", varied.status());
    request.varied.push_back(*std::move(varied));
  }
  request.q_max = options.q_max;
  if (request.seeds.empty() && request.stress_ratios.empty() && request.varied.empty())
    throw CLI::ValidationError("sweep", "give --seeds, --stress-ratio or --set: what is to be varied");
  return request;
}

/// The file's name as far as a label may have it.
std::string default_name(const std::string& path) {
  std::string name;
  for (const char letter : std::filesystem::path(path).stem().string()) {
    const bool plain = (letter >= 'a' && letter <= 'z') || (letter >= 'A' && letter <= 'Z') ||
                       (letter >= '0' && letter <= '9') || letter == '.' || letter == '-' || letter == '_';
    name += plain ? letter : '_';
  }
  return name.substr(0, 40);
}

void say(const Options& options, const std::string& line) {
  std::fprintf(options.json ? stderr : stdout, "%s\n", line.c_str());
  std::fflush(options.json ? stderr : stdout);
}

int conclude(const Options& options, const std::vector<SweepEnd>& ends, const std::string& next) {
  const int exit_code = exit_code_of(ends);
  if (options.json) {
    std::fputs(summary_json(ends).c_str(), stdout);
    return exit_code;
  }
  const int width = is_terminal(stdout) ? terminal_width(stdout) : 0;
  std::fputs(summary_text(ends, width).c_str(), stdout);
  if (exit_code == kRunAgain) std::printf("The same command goes on from there.\n");
  if (exit_code == kOk) std::printf("Next: %s\n", next.c_str());
  return exit_code;
}

int run_here(const Options& options, const std::vector<SweepJob>& jobs) {
  LocalSweepOptions local;
  local.out = options.out;
  local.job_path = options.job;
  local.threads = options.threads;
  const int processors = static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
  local.at_once = options.at_once > 0 ? options.at_once : std::max(1, processors / options.threads);
  if (const auto good = check_sweep_folder(jobs, local); !good.ok()) {
    complain(std::string(good.message()));
    return absl::IsFailedPrecondition(good) ? kInvalidInput : kIoError;
  }
  const auto ends = sweep_locally(jobs, local, [&](const std::string& line) { say(options, line); });
  return conclude(options, ends, "creepctl report " + options.out);
}

/// Brings all jobs that are done but the trunks.
CallResult fetch_done(const Options& options, const std::vector<SweepJob>& jobs,
                      const std::vector<SweepEnd>& ends, Connection& connection) {
  for (std::size_t i = 0; i < jobs.size(); ++i) {
    if (jobs[i].is_trunk || !ends[i].ended || ends[i].exit_code != kOk) continue;
    std::vector<FetchedFile> files;
    const auto folder = std::filesystem::path(options.fetch) / jobs[i].name;
    CallResult result = fetch_all(
        connection, ends[i].place, folder, [](const FetchedFile&) {}, files);
    if (!result.ok()) return result;
    say(options, absl::StrCat(jobs[i].name, ": fetched to ", folder.string()));
  }
  return {};
}

int run_there(const Options& options, const std::vector<SweepJob>& jobs, Connection& connection) {
  RemoteSweepOptions remote;
  remote.name = options.name.empty() ? default_name(options.job) : options.name;
  remote.labels = options.labels;
  remote.priority = options.priority;
  remote.wait = !options.no_wait;
  std::vector<SweepEnd> ends;
  CallResult result = sweep_remotely(
      connection, jobs, remote, [&](const std::string& line) { say(options, line); }, ends);
  if (result.ok() && !options.fetch.empty()) result = fetch_done(options, jobs, ends, connection);
  if (!result.ok()) {
    print_failure(result, options.job);
    const bool disk = absl::IsResourceExhausted(result.status) && result.reason.empty();
    return disk ? kIoError : exit_code_of(result);
  }
  return conclude(options, ends,
                  options.fetch.empty() ? "the same command with --fetch DIR, then creepctl report DIR"
                                        : "creepctl report " + options.fetch);
}

int sweep(const Options& options, const SweepRequest& request) {
  const JobFile job = read_job_file(options.job);
  print_diagnostics(job);
  if (!job.experiment) return kInvalidInput;
  const auto jobs = plan_sweep(job, request);
  if (!jobs.ok()) {
    complain(std::string(jobs.status().message()));
    return kInvalidInput;
  }
  if (options.dry_run) {
    for (const SweepJob& one : *jobs) {
      std::printf(
          "# %s%s\n%s\n", one.name.c_str(),
          one.trunk ? absl::StrCat(", from ", (*jobs)[*one.trunk].name, ", ", one.checkpoint).c_str() : "",
          one.text.c_str());
    }
    return kOk;
  }
  if (!options.out.empty()) return run_here(options, *jobs);
  return with_connection(options.server,
                         [&](Connection& connection) { return run_there(options, *jobs, connection); });
}

void check_name(const std::string& name) {
  const auto plain = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '.' ||
           c == '_' || c == '-';
  };
  if (name.size() > 40 || !std::all_of(name.begin(), name.end(), plain))
    throw CLI::ValidationError("--name", "at most 40 letters, digits, dots, dashes and underscores");
}

void add_options(CLI::App& command, Options& options) {
  command.add_option("JOB", options.job, "The job file")->required();
  command.add_option("--seeds", options.seeds, "Specimens: 5 (1 to 5), 1..5 or 1,3,7");
  command.add_option(
      "--stress-ratio", options.stress_ratios,
      "q/q_max at which the program after the triaxial stage runs, e.g. 0.2,0.4,0.75: one trunk a "
      "seed is sheared, all start from its checkpoints");
  command.add_option("--q-max", options.q_max,
                     "Shear strength, e.g. \"22.6 MPa\" (default: that of the job file)");
  command
      .add_option(
          "--set", options.varied,
          "KEY=VALUE,VALUE of the job file, like numerics.minimum_cycles=20000,40000; can be given again")
      ->expected(1)
      ->take_all()
      ->type_name("KEY=VALUES");
  auto* const out =
      command.add_option("--out", options.out, "Run here, in this folder; without it, on a daemon");
  command
      .add_option("--jobs", options.at_once, "With --out: so many at a time (default: processors / threads)")
      ->check(CLI::Range(1, 1024))
      ->needs(out);
  command.add_option("--threads", options.threads, "With --out: threads of each; never changes a result")
      ->check(CLI::Range(1, 1024))
      ->capture_default_str()
      ->needs(out);
  command.add_option("--name", options.name, "Of the sweep at the daemon (default: that of the file)")
      ->excludes(out);
  command.add_option("--fetch", options.fetch, "Bring the jobs that are done to this folder in the end")
      ->excludes(out);
  command.add_option("--label", options.labels, "KEY=VALUE for all jobs; can be given again")
      ->expected(1)
      ->take_all()
      ->type_name("KEY=VALUE")
      ->excludes(out);
  command.add_option("--priority", options.priority, "Higher starts first")
      ->check(CLI::Range(-100, 100))
      ->capture_default_str()
      ->excludes(out);
  command.add_flag("--no-wait", options.no_wait, "Submit what can be submitted now, do not wait")
      ->excludes(out);
  command.add_flag("--dry-run", options.dry_run, "Print the job files, run nothing");
  command.add_flag("--json", options.json, "Print the end of each job as JSON on stdout, progress on stderr");
  add_server_options(command, options.server);
}

}  // namespace

void add_sweep(CLI::App& app, int& exit_code) {
  CLI::App* command =
      app.add_subcommand("sweep", "Runs a job file over seeds, stress ratios and values of its keys");
  auto options = std::make_shared<Options>();
  add_options(*command, *options);
  command->footer(
      "With --out each job has a folder there; else each is submitted to the daemon, with the labels\n"
      "sweep=NAME and member=seed_1/q_0.2. Called again it goes on: what is done or submitted stays. A job "
      "that\n"
      "fails stops no other. 'creepctl report DIR' and 'creepctl plot DIR' show means over the seeds with "
      "their\n"
      "95 % intervals.\n"
      "Exit code 0: all are done; 1: one failed; 3: one was cancelled; 4: no daemon; 5: wrong job file or "
      "values,\n"
      "or a folder holds another run; 74: input or output failed; 75: stopped, or not all have ended; the "
      "same\n"
      "command goes on.\n\n"
      "Example:\n  creepctl sweep client/examples/triaxial_creep.toml --seeds 1..3 --stress-ratio 0.2,0.4 "
      "--out "
      "sweep");
  command->callback([options, &exit_code] {
    check_name(options->name);
    exit_code = sweep(*options, request_of(*options));
  });
}

}  // namespace creepctl
