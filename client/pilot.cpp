#include "client/pilot.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <numbers>
#include <optional>
#include <sstream>

#include "absl/strings/str_cat.h"
#include "client/job_results.h"
#include "client/run_folder.h"
#include "client/worker_process.h"
#include "core/experiment/experiment_toml.h"
#include "core/experiment/job_text.h"
#include "core/experiment/wording.h"
#include "core/physics/grading.h"
#include "core/run/ageing.h"

namespace creepctl {
namespace {

namespace fs = std::filesystem;

// Fast loading at the density and strain of the job: below the inertial number of the fidelity "fast".
constexpr double kLoadingVelocity = 1.0;   // m/s
constexpr double kAxialVelocity = 0.2;     // m/s; servo-controlled sides follow up to there
constexpr double kInertialNumber = 0.003;  // [-]
constexpr std::int64_t kMinimumCycles = 1000;
constexpr double kDriftTolerance = 0.1;  // [-]

/// Removed with all that is in it.
class TemporaryFolder {
 public:
  TemporaryFolder() {
    std::error_code error;
    std::string pattern = (fs::temp_directory_path(error) / "creepctl-plan-XXXXXX").string();
    if (!error && ::mkdtemp(pattern.data()) != nullptr) path_ = pattern;
  }
  ~TemporaryFolder() {
    std::error_code ignored;
    if (!path_.empty()) fs::remove_all(path_, ignored);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;

  const fs::path& path() const { return path_; }

 private:
  fs::path path_;
};

std::string velocity(double value) { return absl::StrCat("\"", creep::shortest(value), " m/s\""); }

/// The keys that make the job a small and short one.
std::vector<creep::Override> overrides(const creep::Experiment& job, double particles) {
  const creep::Numerics& numerics = job.numerics;
  const double all = particle_count(job.specimen);
  std::vector<creep::Override> keys = {{"output.snapshots", "none"}};
  if (job.specimen.particles) {
    keys.emplace_back("specimen.particles", std::to_string(static_cast<std::int64_t>(particles)));
  } else {
    keys.emplace_back(
        "specimen.side",
        absl::StrCat("\"", creep::shortest(*job.specimen.side * std::cbrt(particles / all)), " m\""));
  }
  if (numerics.minimum_cycles > kMinimumCycles) {
    keys.emplace_back("numerics.minimum_cycles", std::to_string(kMinimumCycles));
    if (!numerics.drift_tolerance)
      keys.emplace_back("numerics.drift_tolerance", creep::shortest(kDriftTolerance));
  }
  if (!numerics.ageing_error_tolerance) {
    const auto breakages = static_cast<double>(
        creep::breakages_per_ageing(numerics, static_cast<std::int64_t>(std::llround(all))));
    const auto fewer = std::max<std::int64_t>(1, std::llround(breakages * particles / all));
    keys.emplace_back("numerics.breakages_per_ageing", std::to_string(fewer));
  }
  if (numerics.loading_velocity < kLoadingVelocity) {
    keys.emplace_back("numerics.loading_velocity", velocity(kLoadingVelocity));
    if (!numerics.inertial_number_limit)
      keys.emplace_back("numerics.inertial_number_limit", creep::shortest(kInertialNumber));
  }
  for (std::size_t i = 0; i < job.program.size(); ++i) {
    const auto* triaxial = std::get_if<creep::TriaxialStage>(&job.program[i]);
    if (triaxial != nullptr && triaxial->axial_velocity < kAxialVelocity)
      keys.emplace_back(absl::StrCat("program.", i, ".axial_velocity"), velocity(kAxialVelocity));
  }
  return keys;
}

/// Computes what is in the folder; how it ended. Error: Unavailable, Aborted.
absl::StatusOr<std::string> compute(const fs::path& folder, int threads) {
  auto worker =
      WorkerProcess::start({folder.string(), "--threads", std::to_string(threads)}, folder / "worker.log");
  if (!worker.ok()) return worker.status();
  std::optional<WorkerEnd> end;
  while (!(end = worker->wait(std::chrono::milliseconds(100)))) {
  }
  std::ifstream file(folder / "verdict.json");
  const auto verdict = nlohmann::ordered_json::parse(file, nullptr, false);
  const std::string reason = verdict.is_object() ? verdict.value("reason", std::string())
                                                 : absl::StrCat("exit code ", end->exit_code);
  if (worker->stopping()) return absl::AbortedError("stopped");
  if (end->signal != 0 || end->exit_code != 0)
    return absl::AbortedError(absl::StrCat("a small specimen of this job was stopped: ", reason));
  return reason;
}

struct Cost {
  double wall_seconds = 0.0;
  double particle_steps = 0.0;
};

/// Of packing (row -1 of stage_timings.csv), and of all rows after it.
absl::StatusOr<std::pair<Cost, Cost>> read_costs(const fs::path& folder) {
  std::ifstream file(folder / "stage_timings.csv");
  std::ostringstream text;
  text << file.rdbuf();
  const auto table = NumberTable::parse(text.str(), "stage_timings.csv");
  if (!table.ok()) return table.status();
  std::pair<Cost, Cost> costs;
  for (std::size_t row = 0; row < table->rows(); ++row) {
    Cost& cost = table->at(row, "stage_row") < 0.0 ? costs.first : costs.second;
    cost.wall_seconds += table->at(row, "wall_seconds");
    cost.particle_steps += table->at(row, "particle_steps");
  }
  return costs;
}

/// Sums the rows of stages.csv by stage of the program.
std::vector<PilotStage> read_stages(const NumberTable& rows, double particles) {
  std::vector<PilotStage> stages;
  double strain = 0.0, clock = 0.0;
  for (std::size_t row = 0; row < rows.rows(); ++row) {
    const auto index = static_cast<std::size_t>(rows.at(row, "stage"));
    if (index >= stages.size()) stages.resize(index + 1);
    PilotStage& stage = stages[index];
    const double cycles = rows.at(row, "cycles");
    const double strain_end = rows.at(row, "axial_strain_end");
    const double clock_end = rows.at(row, "dynamic_time_s") + rows.at(row, "suspended_time_s");
    stage.growth = rows.at(row, "particles") / particles;
    if (rows.at(row, "dynamic_stage") < 0.0) {
      stage.loading_cycles += cycles;
      stage.shortening += std::abs(strain_end - strain);
      stage.time_step = cycles > 0.0 ? (clock_end - clock) / cycles : 0.0;
    } else {
      stage.dynamic_cycles += (cycles - stage.dynamic_cycles) / ++stage.dynamic_stages;
      stage.time_step = rows.at(row, "time_step_s");
    }
    strain = strain_end;
    clock = clock_end;
  }
  return stages;
}

}  // namespace

double particle_count(const creep::SpecimenSpec& specimen) {
  if (specimen.particles) return static_cast<double>(*specimen.particles);
  const double solid = std::pow(specimen.side.value_or(0.0), 3) / (1.0 + specimen.void_ratio);
  return solid / (std::numbers::pi / 6.0 * creep::mean_cubed_diameter(specimen.grading));
}

absl::StatusOr<Pilot> run_pilot(const JobFile& job, int threads) {
  if (job.experiment->start) {
    return absl::InvalidArgumentError(
        "a job with [start] cannot be planned: its specimen is in a checkpoint; plan the job that it starts "
        "from with the same stages");
  }
  const double particles = std::floor(std::min(kPilotParticles, particle_count(job.experiment->specimen)));
  const auto text = creep::with_overrides(job.text, overrides(*job.experiment, particles));
  if (!text.ok()) return text.status();
  const creep::ParseResult small = creep::parse_experiment(*text);
  if (!small.experiment) return absl::InvalidArgumentError(small.errors.front().message);
  const TemporaryFolder folder;
  if (folder.path().empty()) return absl::UnavailableError("cannot make a temporary folder");
  if (auto begun = begin_run_folder(folder.path() / "pilot", *text); !begun.ok()) return begun;
  const auto reason = compute(folder.path() / "pilot", threads);
  if (!reason.ok()) return reason.status();
  const auto results = read_job_results(folder.path() / "pilot");
  if (!results.ok()) return results.status();
  const auto costs = read_costs(folder.path() / "pilot");
  if (!costs.ok()) return costs.status();
  const auto& [packing, program] = *costs;
  Pilot pilot;
  pilot.particles = particle_count(small.experiment->specimen);
  pilot.loading_velocity = small.experiment->numerics.loading_velocity;
  pilot.axial_velocity = kAxialVelocity;
  pilot.breakages = static_cast<double>(
      creep::breakages_per_ageing(small.experiment->numerics, std::llround(pilot.particles)));
  pilot.packing_cycles = packing.particle_steps / pilot.particles;
  pilot.packing_speed = packing.particle_steps / std::max(packing.wall_seconds, 1e-6);
  pilot.speed = program.particle_steps / std::max(program.wall_seconds, 1e-6);
  pilot.seconds = packing.wall_seconds + program.wall_seconds;
  pilot.reason = *reason;
  pilot.stages = read_stages(results->stages, pilot.particles);
  return pilot;
}

}  // namespace creepctl
