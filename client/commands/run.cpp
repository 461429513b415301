#include "client/commands/commands.h"

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <thread>

#include "client/job_file/job_file.h"
#include "client/local/run_end.h"
#include "client/local/run_folder.h"
#include "client/local/start_checkpoint.h"
#include "client/local/worker_process.h"
#include "client/terminal/exit_codes.h"
#include "client/terminal/progress_display.h"
#include "client/terminal/run_progress.h"
#include "client/terminal/terminal.h"

namespace creepctl {
namespace {

using nlohmann::ordered_json;

struct Options {
  std::string job;
  std::string out;
  int threads = 1;
  bool allow_inexact = false;
  std::int64_t rebuild_every = 0;
  bool profile = false;
  bool json = false;
};

void print_summary(const std::filesystem::path& folder) {
  const ordered_json summary = read_json(folder / "summary.json");
  std::printf("%s\n", word(summary, "reason").c_str());
  const auto figures = summary.find("figures");
  if (figures != summary.end() && figures->is_object()) {
    for (const auto& [name, value] : figures->items()) {
      if (value.is_number()) std::printf("  %-36s %.6g\n", name.c_str(), value.get<double>());
    }
  }
  const auto seconds = summary.find("wall_seconds");
  const auto speed = summary.find("particle_steps_per_second");
  if (seconds != summary.end() && seconds->is_number() && speed != summary.end() && speed->is_number()) {
    std::printf("  %-36s %s\n", "wall time", short_duration(seconds->get<double>()).c_str());
    std::printf("  %-36s %.2e\n", "particle-steps/s", speed->get<double>());
  }
  std::printf("  %-36s %s\n", "state_digest", word(summary, "state_digest").c_str());
  std::printf("Results in %s: samples.csv, stages.csv, breakages.csv, gsd.csv, summary.json\n",
              folder.c_str());
  std::printf("Next: creepctl report %s\n", folder.c_str());
}

/// The table as the worker wrote it, aligned.
void print_profile(const std::filesystem::path& folder) {
  std::istringstream table(read_text(folder / "profile.csv"));
  std::string activity, seconds, share;
  std::getline(table, activity);
  std::printf("Where the time of this attempt went:\n");
  while (std::getline(table, activity, ',') && std::getline(table, seconds, ',') &&
         std::getline(table, share)) {
    std::printf("  %-12s %10.1f s %6.1f %%\n", activity.c_str(), std::atof(seconds.c_str()),
                100.0 * std::atof(share.c_str()));
  }
}

void print_json(int exit_code, const std::filesystem::path& folder, bool computed) {
  const ordered_json value = {{"exit_code", exit_code},
                              {"computed", computed},
                              {"directory", folder.string()},
                              {"verdict", read_json(folder / "verdict.json")},
                              {"summary", read_json(folder / "summary.json")}};
  std::printf("%s\n", value.dump(2, ' ', false, ordered_json::error_handler_t::replace).c_str());
}

int compute(const Options& options, const creep::Experiment& experiment) {
  const std::filesystem::path folder = options.out;
  if (!wait_for_orphan(folder)) {
    complain(folder.string() + " is in use by another run");
    return kFailed;
  }
  std::error_code ignored;  // progress of an earlier attempt, which is not to be shown
  std::filesystem::remove(folder / "progress.json", ignored);
  std::vector<std::string> arguments = {folder.string(), "--threads", std::to_string(options.threads)};
  if (options.allow_inexact) arguments.push_back("--allow-inexact");
  if (options.profile) arguments.push_back("--profile");
  if (options.rebuild_every > 0) {
    arguments.push_back("--rebuild-every");
    arguments.push_back(std::to_string(options.rebuild_every));
  }
  auto worker = WorkerProcess::start(arguments, folder / "worker.log");
  if (!worker.ok()) {
    complain(std::string(worker.status().message()));
    return kFailed;
  }
  ProgressDisplay display(options.json ? stderr : stdout, experiment);
  const auto refresh = [&](bool at_the_end) {
    if (const auto progress = parse_run_progress(read_text(folder / "progress.json"))) {
      display.show(*progress, at_the_end);
    }
  };
  std::optional<WorkerEnd> end;
  while (!(end = worker->wait(std::chrono::milliseconds(250)))) refresh(false);
  refresh(true);
  const int exit_code = exit_code_of(*end);
  if (exit_code != kOk) {
    for (const std::string& sentence : explanation(*end, folder)) complain(sentence);
  }
  if (options.json) {
    print_json(exit_code, folder, true);
  } else if (exit_code == kOk) {
    print_summary(folder);
  }
  if (options.profile && !options.json) print_profile(folder);
  return exit_code;
}

/// The job file is the one in the folder of the run itself, with the checkpoint it starts from beside it.
bool has_its_start(const std::filesystem::path& folder, const JobFile& job) {
  std::error_code error;
  return read_text(folder / "job.toml") == job.text &&
         std::filesystem::is_regular_file(folder / "checkpoints" / "start", error);
}

int run(const Options& options) {
  JobFile job = read_job_file(options.job);
  print_diagnostics(job);
  if (!job.experiment) return kInvalidInput;
  std::string start;
  if (job.experiment->start && !has_its_start(options.out, job)) {
    auto taken = take_start(job);
    if (!taken.ok()) {
      complain(std::string(taken.status().message()));
      return kInvalidInput;
    }
    start = *std::move(taken);
  }
  const auto state = look_at_run_folder(options.out, job.text, options.job);
  if (!state.ok()) {
    complain(std::string(state.status().message()));
    return absl::IsFailedPrecondition(state.status()) ? kInvalidInput : kIoError;
  }
  if (*state == RunFolderState::kFinished) {
    if (options.json) {
      print_json(kOk, options.out, false);
    } else {
      std::printf("%s is finished already, nothing to do: ", options.out.c_str());
      print_summary(options.out);
    }
    return kOk;
  }
  if (*state == RunFolderState::kNew) {
    if (auto begun = begin_run_folder(options.out, job.text); !begun.ok()) {
      complain(std::string(begun.message()));
      return kIoError;
    }
  } else {
    std::fprintf(stderr, "continuing the run in %s\n", options.out.c_str());
  }
  if (!start.empty()) {
    if (auto written = write_start(options.out, start); !written.ok()) {
      complain(std::string(written.message()));
      return kIoError;
    }
  }
  return compute(options, *job.experiment);
}

}  // namespace

void add_run(CLI::App& app, int& exit_code) {
  CLI::App* command = app.add_subcommand("run", "Runs a job in a directory, or continues it there");
  auto options = std::make_shared<Options>();
  options->threads = static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
  command->add_option("JOB", options->job, "The job file")->required();
  command->add_option("--out", options->out, "The directory of the run")->required();
  command->add_option("--threads", options->threads, "Threads; never changes a result")
      ->check(CLI::Range(1, 1024))
      ->capture_default_str();
  command->add_flag("--allow-inexact", options->allow_inexact,
                    "Continue although this machine computes other bits; is recorded in the results");
  command->add_flag("--profile", options->profile,
                    "Say in the end where the time went, and write profile.csv");
  command->add_option("--rebuild-every", options->rebuild_every, "Search neighbours every so many cycles")
      ->check(CLI::NonNegativeNumber)
      ->group("");
  command->add_flag("--json", options->json, "Print the result as JSON on stdout, progress on stderr");
  command->footer(
      "A directory with an unfinished run of the same job file is continued; a finished one is left as it "
      "is.\n"
      "Ctrl-C checkpoints and stops.\n"
      "Exit code 0: done, also if the specimen failed by creep; 1: the run failed; 5: wrong input;\n"
      "74: input or output failed, e.g. the disk is full; 75: stopped with a checkpoint, run again.\n\n"
      "Example:\n  creepctl run client/examples/oedometer_creep.toml --out creep-2d --threads 2");
  command->callback([options, &exit_code] { exit_code = run(*options); });
}

}  // namespace creepctl
