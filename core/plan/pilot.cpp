#include "core/plan/pilot.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "absl/strings/str_cat.h"
#include "core/analysis/number_table.h"
#include "core/experiment/experiment_toml.h"
#include "core/experiment/fidelity.h"
#include "core/experiment/job_text.h"
#include "core/experiment/wording.h"
#include "core/physics/grading.h"

namespace creep {
namespace {

// Fast loading at the density and strain of the job: below the inertial number of the fidelity "fast".
constexpr double kLoadingVelocity = 1.0;   // m/s
constexpr double kAxialVelocity = 0.2;     // m/s; servo-controlled sides follow up to there
constexpr double kInertialNumber = 0.003;  // [-]
constexpr std::int64_t kMinimumCycles = 1000;
constexpr double kDriftTolerance = 0.1;  // [-]

std::string velocity(double value) { return absl::StrCat("\"", shortest(value), " m/s\""); }

/// The keys that make the job a small and short one.
std::vector<Override> overrides(const Experiment& job, double particles) {
  const Numerics& numerics = job.numerics;
  const double all = particle_count(job.specimen);
  std::vector<Override> keys = {{"output.snapshots", "none"}};
  if (job.specimen.particles) {
    keys.emplace_back("specimen.particles", std::to_string(static_cast<std::int64_t>(particles)));
  } else {
    keys.emplace_back("specimen.side",
                      absl::StrCat("\"", shortest(*job.specimen.side * std::cbrt(particles / all)), " m\""));
  }
  if (numerics.minimum_cycles > kMinimumCycles) {
    keys.emplace_back("numerics.minimum_cycles", std::to_string(kMinimumCycles));
    if (!numerics.drift_tolerance) keys.emplace_back("numerics.drift_tolerance", shortest(kDriftTolerance));
  }
  if (!numerics.ageing_error_tolerance) {
    const auto breakages =
        static_cast<double>(breakages_per_ageing(numerics, static_cast<std::int64_t>(std::llround(all))));
    const auto fewer = std::max<std::int64_t>(1, std::llround(breakages * particles / all));
    keys.emplace_back("numerics.breakages_per_ageing", std::to_string(fewer));
  }
  if (numerics.loading_velocity < kLoadingVelocity) {
    keys.emplace_back("numerics.loading_velocity", velocity(kLoadingVelocity));
    if (!numerics.inertial_number_limit)
      keys.emplace_back("numerics.inertial_number_limit", shortest(kInertialNumber));
  }
  for (std::size_t i = 0; i < job.program.size(); ++i) {
    const auto* triaxial = std::get_if<TriaxialStage>(&job.program[i]);
    if (triaxial != nullptr && triaxial->axial_velocity < kAxialVelocity)
      keys.emplace_back(absl::StrCat("program.", i, ".axial_velocity"), velocity(kAxialVelocity));
  }
  return keys;
}

struct Cost {
  double wall_seconds = 0.0;
  double particle_steps = 0.0;
};

/// Of packing (row -1 of stage_timings.csv), and of all rows after it.
absl::StatusOr<std::pair<Cost, Cost>> read_costs(const std::string& text) {
  const auto table = NumberTable::parse(text, "stage_timings.csv");
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

double particle_count(const SpecimenSpec& specimen) {
  if (specimen.particles) return static_cast<double>(*specimen.particles);
  const double solid = std::pow(specimen.side.value_or(0.0), 3) / (1.0 + specimen.void_ratio);
  return solid / (std::numbers::pi / 6.0 * mean_cubed_diameter(specimen.grading));
}

absl::StatusOr<std::string> pilot_text(std::string_view text, const Experiment& job) {
  if (job.start) {
    return absl::InvalidArgumentError(
        "a job with [start] cannot be planned: its specimen is in a checkpoint; plan the job that it starts "
        "from with the same stages");
  }
  return with_overrides(text,
                        overrides(job, std::floor(std::min(kPilotParticles, particle_count(job.specimen)))));
}

absl::StatusOr<Pilot> read_pilot(const PilotTables& tables) {
  const ParseResult small = parse_experiment(tables.job);
  if (!small.experiment) return absl::InvalidArgumentError(small.errors.front().message);
  const auto rows = NumberTable::parse(tables.stages, "stages.csv");
  if (!rows.ok()) return rows.status();
  const auto costs = read_costs(tables.timings);
  if (!costs.ok()) return costs.status();
  const auto& [packing, program] = *costs;
  Pilot pilot;
  pilot.particles = particle_count(small.experiment->specimen);
  pilot.loading_velocity = small.experiment->numerics.loading_velocity;
  pilot.axial_velocity = kAxialVelocity;
  pilot.breakages =
      static_cast<double>(breakages_per_ageing(small.experiment->numerics, std::llround(pilot.particles)));
  pilot.packing_cycles = packing.particle_steps / pilot.particles;
  pilot.packing_speed = packing.particle_steps / std::max(packing.wall_seconds, 1e-6);
  pilot.speed = program.particle_steps / std::max(program.wall_seconds, 1e-6);
  pilot.seconds = packing.wall_seconds + program.wall_seconds;
  pilot.reason = tables.reason;
  pilot.stages = read_stages(*rows, pilot.particles);
  return pilot;
}

}  // namespace creep
