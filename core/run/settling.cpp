#include "core/run/settling.h"

#include <algorithm>
#include <cmath>

#include "core/dem/dynamics.h"
#include "core/dem/measures.h"
#include "core/run/ageing.h"
#include "core/run/stage_control.h"

namespace creep {
namespace {

constexpr std::int64_t kSettleWindow = 5000;
constexpr std::int64_t kUnsettledFactor = 10;  // x minimum_cycles

}  // namespace

std::int64_t settle_window(const Numerics& numerics) {
  return std::min(kSettleWindow, numerics.minimum_cycles);
}

std::int64_t most_cycles(const Numerics& numerics) {
  return kUnsettledFactor * std::max(numerics.minimum_cycles, kSettleWindow);
}

double watch_stress(Aim& aim, const Stage& stage, const Specimen& specimen, const Numerics& numerics) {
  const double deviation = off_target(stage, aim, specimen);
  if (!holds_strain(stage)) return deviation;
  const double stress = specimen.walls.stress(2);
  const double change = std::fabs(stress - aim.axial) / std::max(stress, aim.axial);
  if (change >= numerics.settle_tolerance) aim.axial = stress;
  return std::max(deviation, change);
}

void watch_calm(Calm& calm, double deviation, bool failed, const Numerics& numerics) {
  const bool on_target = deviation < numerics.settle_tolerance;
  if (!on_target || failed) calm.quiet_since = calm.cycle;
  if (on_target && !calm.on_target) calm.on_target = calm.cycle;
}

bool at_rest(const Calm& calm, const Specimen& specimen, const Numerics& numerics) {
  return calm.cycle - calm.quiet_since >= settle_window(numerics) &&
         specimen.unbalanced_force_ratio < numerics.unbalanced_tolerance;
}

double stress_gap(const Specimen& specimen, const ContactModel& model) {
  const double axial = specimen.walls.stress(2), radial = radial_stress(specimen.walls);
  const ContactStress carried = contact_stress(specimen, model);
  return std::max(std::fabs(carried.axial - axial), std::fabs(carried.radial - radial)) /
         std::max(axial, radial);
}

void watch_failure_times(DynamicStage& stage, const Specimen& specimen, const Experiment& experiment,
                         std::int64_t breakages, double left) {
  const std::int64_t looked = stage.drift ? stage.drift->cycle : 0;
  if ((specimen.cycle - 1) % Dynamics::kMeasureInterval != 0 ||
      stage.calm.cycle - looked < settle_window(experiment.numerics)) {
    return;
  }
  const double next = time_to_failures(specimen, experiment.material, breakages);
  const double end = log_end_of_ageing(specimen.clocks.creep_time(), next, std::max(0.0, left));
  Drift drift{stage.calm.cycle, end, {}};
  if (stage.drift) drift.change = std::fabs(end - stage.drift->end_of_ageing);
  stage.drift = drift;
}

bool failure_times_stand(const DynamicStage& stage, const Numerics& numerics) {
  const auto& tolerance = numerics.drift_tolerance;
  return !tolerance || (stage.drift && stage.drift->change && *stage.drift->change < *tolerance);
}

}  // namespace creep
