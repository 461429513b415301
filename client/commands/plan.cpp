#include "client/commands/commands.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <thread>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "client/job_file/job_file.h"
#include "client/local/pilot.h"
#include "client/remote/connection.h"
#include "client/remote/remote_plan.h"
#include "client/terminal/exit_codes.h"
#include "client/terminal/run_progress.h"
#include "client/terminal/terminal.h"
#include "core/experiment/fidelity.h"
#include "core/experiment/numerics_text.h"
#include "core/plan/plan.h"

namespace creepctl {
namespace {

using creep::Pilot;
using creep::Plan;
using creep::PlannedStage;
using creep::Range;
using nlohmann::ordered_json;

struct Options {
  ServerOptions server;
  std::string job;
  bool daemon = false;
  int threads = 1;
  bool json = false;
};

ordered_json to_json(const Range& range) {
  return {{"expected", range.expected}, {"least", range.least}, {"most", range.most}};
}

void print_json(const JobFile& job, const Plan& plan, const Pilot& pilot, int threads) {
  ordered_json stages = ordered_json::array();
  for (const PlannedStage& stage : plan.stages) {
    ordered_json value = {{"stage", stage.text},
                          {"time_step_s", stage.time_step},
                          {"cycles", std::llround(stage.cycles)},
                          {"particle_steps", stage.particle_steps}};
    if (stage.dynamic_stages.expected > 0.0) value["dynamic_stages"] = to_json(stage.dynamic_stages);
    stages.push_back(std::move(value));
  }
  ordered_json numerics = ordered_json::object();
  for (const creep::NumericsValue& at : creep::numerics_values(job.experiment->numerics)) {
    numerics[std::string(at.key)] = ordered_json::parse(at.value);
  }
  const ordered_json value = {{"file", job.path},
                              {"particles", std::llround(plan.particles)},
                              {"numerics", numerics},
                              {"error", plan.error ? ordered_json(*plan.error) : ordered_json(nullptr)},
                              {"packing_particle_steps", plan.packing_particle_steps},
                              {"stages", stages},
                              {"threads", threads},
                              {"wall_seconds", to_json(plan.wall_seconds)},
                              {"memory_bytes", std::llround(plan.memory)},
                              {"pilot",
                               {{"particles", std::llround(pilot.particles)},
                                {"breakages_per_ageing", std::llround(pilot.breakages)},
                                {"wall_seconds", pilot.seconds},
                                {"particle_steps_per_second", pilot.speed},
                                {"reason", pilot.reason}}}};
  std::printf("%s\n", value.dump(2, ' ', false, ordered_json::error_handler_t::replace).c_str());
}

std::string error_text(const JobFile& job, const Plan& plan) {
  const std::string& name = job.experiment->numerics.fidelity;
  if (!plan.error) return absl::StrCat("not measured: keys of \"", name, "\" are overridden");
  return absl::StrFormat(
      "%.2g %% (\"%s\", on %d particles; the far end of the 95 %% interval of void ratio and "
      "creep strain)",
      100.0 * *plan.error, name, creep::kMeasuredParticles);
}

void line(const char* label, const std::string& text) { std::printf("  %-16s %s\n", label, text.c_str()); }

void print_text(const JobFile& job, const Plan& plan, const Pilot& pilot, int threads,
                const char* time_label) {
  std::printf("%s: %lld particles\n", job.path.c_str(), std::llround(plan.particles));
  line("numerics", creep::numerics_text(job.experiment->numerics));
  for (const PlannedStage& stage : plan.stages) {
    std::string text = absl::StrFormat("%.2g cycles of %.2g s", stage.cycles, stage.time_step);
    if (const Range& count = stage.dynamic_stages; count.expected > 0.0) {
      text =
          absl::StrFormat("%.0f dynamic stages (%.0f to %.0f), ", count.expected, count.least, count.most) +
          text;
    }
    line("stage", stage.text + ": " + text);
  }
  const Range& wall = plan.wall_seconds;
  line(time_label, absl::StrFormat("%s (%s to %s), %d threads", short_duration(wall.expected),
                                   short_duration(wall.least), short_duration(wall.most), threads));
  line("memory", absl::StrFormat("%.0f MB", std::ceil(plan.memory / 1e6)));
  line("error", error_text(job, plan));
  line("basis",
       absl::StrFormat("this job on %lld particles, n_age %lld, dynamic stages as short as they settle: "
                       "%s, %.2g particle-steps/s",
                       std::llround(pilot.particles), std::llround(pilot.breakages),
                       short_duration(pilot.seconds), pilot.speed));
  line("", pilot.stages.size() < job.experiment->program.size()
               ? "it ended early (" + pilot.reason + "): later stages are not counted"
               : "it ended with: " + pilot.reason);
}

void print(const Options& options, const JobFile& job, const Plan& planned, const Pilot& pilot, int threads) {
  if (options.json) {
    print_json(job, planned, pilot, threads);
  } else {
    print_text(job, planned, pilot, threads, options.daemon ? "time there" : "time here");
  }
}

int plan_there(const Options& options, const JobFile& job, Connection& connection) {
  RemotePlan remote;
  const CallResult result = plan_remotely(connection, job.text, complain, remote);
  if (!result.ok()) {
    print_failure(result, options.job);
    return exit_code_of(result);
  }
  print(options, job, remote.plan, remote.pilot, remote.threads);
  return kOk;
}

int plan(const Options& options) {
  const JobFile job = read_job_file(options.job);
  print_diagnostics(job);
  if (!job.experiment) return kInvalidInput;
  if (options.daemon) {
    return with_connection(options.server,
                           [&](Connection& connection) { return plan_there(options, job, connection); });
  }
  const auto pilot = run_pilot(job, options.threads);
  if (!pilot.ok()) {
    complain(std::string(pilot.status().message()));
    return absl::IsInvalidArgument(pilot.status()) ? kInvalidInput : kFailed;
  }
  const Plan planned = make_plan(*job.experiment, *pilot);
  print(options, job, planned, *pilot, options.threads);
  return kOk;
}

}  // namespace

void add_plan(CLI::App& app, int& exit_code) {
  CLI::App* command =
      app.add_subcommand("plan", "Predicts time, memory and error of a job, from a small specimen of it");
  auto options = std::make_shared<Options>();
  options->threads = static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
  command->add_option("JOB", options->job, "The job file")->required();
  auto* const threads =
      command->add_option("--threads", options->threads, "Threads that the job will have here")
          ->check(CLI::Range(1, 1024))
          ->capture_default_str();
  command->add_flag("--daemon", options->daemon, "Plan for the daemon: the small specimen is computed there")
      ->excludes(threads);
  add_server_options(*command, options->server);
  command->add_flag("--json", options->json, "Print JSON on stdout");
  command->footer(
      "Computes the program on at most 1500 particles, loaded fast and with short dynamic stages, in a\n"
      "temporary folder: some seconds to a minute. Dynamic stages, cycles and hours of the job follow from\n"
      "it; another seed may differ by the range that is given. Not for a job with [start]. With --daemon "
      "the\n"
      "small specimen is a job there while it runs, with the label pilot.\n"
      "Exit code 0: planned; 1: a guard stopped the small specimen, or no worker; 4: no daemon;\n"
      "5: wrong input.\n\n"
      "Example:\n  creepctl plan client/examples/oedometer_creep.toml --threads 2");
  command->callback([options, &exit_code] { exit_code = plan(*options); });
}

}  // namespace creepctl
