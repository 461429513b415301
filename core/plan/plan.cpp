#include "core/plan/plan.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/experiment/fidelity.h"
#include "core/experiment/numerics_text.h"
#include "core/experiment/stage_text.h"
#include "core/physics/grading.h"

namespace creep {
namespace {

/// Edge of the cube after packing [m].
double edge(const SpecimenSpec& specimen) {
  const double solid =
      particle_count(specimen) * std::numbers::pi / 6.0 * mean_cubed_diameter(specimen.grading);
  return std::cbrt(solid * (1.0 + specimen.void_ratio));
}

/// Cycles of loading: as many as the pilot's where it closed as fast, over a longer edge; else the way over
/// the velocity.
double loading_cycles(const Experiment& job, const Stage& stage, const PilotStage& took, const Pilot& pilot) {
  const auto* triaxial = std::get_if<TriaxialStage>(&stage);
  const double own = triaxial != nullptr ? triaxial->axial_velocity : job.numerics.loading_velocity;
  const double longer = std::cbrt(particle_count(job.specimen) / pilot.particles);
  const double scaled = took.loading_cycles * longer;
  if (took.time_step <= 0.0) return scaled;
  return std::max(scaled, took.shortening * edge(job.specimen) / (own * took.time_step));
}

/// Dynamic stages of a hold: one, and one after each jump. Failures go with the particles, jumps with
/// failures over n_age.
double dynamic_stages(const Experiment& job, const PilotStage& took, const Pilot& pilot) {
  if (took.dynamic_stages < 1.0) return 0.0;
  double more = 1.0;
  if (!job.numerics.ageing_error_tolerance) {
    const double particles = particle_count(job.specimen);
    const auto breakages = static_cast<double>(breakages_per_ageing(job.numerics, std::llround(particles)));
    more = particles / pilot.particles * pilot.breakages / breakages;
  }
  return 1.0 + (took.dynamic_stages - 1.0) * more;
}

std::optional<double> measured_error(const Numerics& numerics) {
  const auto index = fidelity_index(numerics.fidelity);
  if (!index) return std::nullopt;
  Numerics as_named = fidelity_numerics(*index);
  as_named.skin = numerics.skin;  // changes no result
  if (numerics_text(as_named) != numerics_text(numerics)) return std::nullopt;
  return fidelity_measure(*index).error;
}

/// The worker at its highest: 18 MB where 3 000 grains became 5 000, 40 MB where 11 500 became 25 000.
constexpr double kProgramMemory = 10.0 * 1024 * 1024;  // bytes
constexpr double kMemoryEach = 1.4 * 1024;             // bytes a particle, fragments too

}  // namespace

Plan make_plan(const Experiment& job, const Pilot& pilot) {
  Plan plan;
  plan.particles = particle_count(job.specimen);
  plan.packing_particle_steps = plan.particles * pilot.packing_cycles;
  plan.error = measured_error(job.numerics);
  double steps = 0.0, growth = 1.0;
  for (std::size_t i = 0; i < std::min(job.program.size(), pilot.stages.size()); ++i) {
    const PilotStage& took = pilot.stages[i];
    PlannedStage stage;
    stage.text = stage_text(job.program[i]);
    const double count = dynamic_stages(job, took, pilot);
    stage.dynamic_stages = {count, std::floor(count / kStageFactor), std::ceil(count * kStageFactor)};
    const double each = std::max(static_cast<double>(job.numerics.minimum_cycles), took.dynamic_cycles);
    stage.cycles = loading_cycles(job, job.program[i], took, pilot) + count * each;
    stage.time_step = took.time_step;
    stage.particle_steps = stage.cycles * plan.particles * took.growth;
    steps += stage.particle_steps;
    growth = std::max(growth, took.growth);
    plan.stages.push_back(std::move(stage));
  }
  const double seconds = plan.packing_particle_steps / pilot.packing_speed + steps / pilot.speed;
  plan.wall_seconds = {seconds, seconds / kSecondsFactor, seconds * kSecondsFactor};
  plan.memory = kProgramMemory + kMemoryEach * plan.particles * growth;
  return plan;
}

}  // namespace creep
