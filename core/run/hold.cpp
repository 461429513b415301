// A hold: dynamic stages, each until it has come to rest, with ageing jumps between them.
#include <algorithm>

#include "absl/strings/str_cat.h"
#include "core/dem/measures.h"
#include "core/experiment/fidelity.h"
#include "core/output/samples.h"
#include "core/run/ageing.h"
#include "core/run/guards.h"
#include "core/run/run_impl.h"
#include "core/run/settling.h"
#include "core/run/stage_control.h"

namespace creep {
namespace {

constexpr double kCreepFailureStrain = 0.2;  // axial creep strain
constexpr double kUnsettledStrain = 1e-3;    // in the second half of a stage: it flows, it does not settle

/// The hold moves on whether or not there are snapshots: output changes no bit of a checkpoint.
bool passes_decade_of_age(Hold& hold, const Clocks& clocks) {
  const double age = clocks.age - hold.start.age;
  const bool passes = age >= hold.next_snapshot_age;
  while (age >= hold.next_snapshot_age) hold.next_snapshot_age *= 10.0;
  return passes;
}

/// From the last jump to the n_age of this one, and what this one promises. @param left  of the hold [s]
void adapt_breakages(Hold& hold, double left, const RunState& state, const Experiment& experiment) {
  const double now = state.specimen.clocks.creep_time();
  const auto wait = [&](std::int64_t wanted) {
    return time_to_failures(state.specimen, experiment.material, wanted);
  };
  if (const auto& last = hold.promise) {
    const double error =
        relative_strain_error({last->aged_from, now, last->promised, wait(hold.breakages), left});
    hold.breakages = adapted_breakages(hold.breakages, error, *experiment.numerics.ageing_error_tolerance,
                                       state.packed->count);
  }
  const double once = std::min(wait(hold.breakages), left);
  hold.promise.reset();
  if (now > 0.0) hold.promise = Promise{now, std::max(0.0, wait(2 * hold.breakages) - once)};
}

}  // namespace

Hold Run::Impl::new_hold() const {
  const Specimen& specimen = state.specimen;
  Hold hold;
  hold.start = {specimen.clocks.age, axial_strain(specimen), specimen.walls.stress(2),
                void_ratio(specimen, experiment.material.density).with_fines, specimen.broken_total};
  hold.breakages = breakages_per_ageing(experiment.numerics, state.packed->count);
  return hold;
}

DynamicStage Run::Impl::new_dynamic_stage(std::int64_t broken_at_start, bool closing) const {
  const Specimen& specimen = state.specimen;
  DynamicStage stage;
  stage.start = {specimen.clocks.creep_time(), specimen.clocks.suspended_time, broken_at_start,
                 specimen.broken_total};
  stage.closing = closing;
  return stage;
}

double Run::Impl::time_left() const { return *duration_of(stage()) - state.specimen.clocks.creep_time(); }

std::int64_t Run::Impl::next_breakages() const {
  return experiment.numerics.ageing_error_tolerance
             ? state.hold->breakages
             : breakages_per_ageing(experiment.numerics, state.packed->count);
}

void Run::Impl::step(DynamicStage& dynamic, Batch& batch) {
  const Numerics& numerics = experiment.numerics;
  const CycleResult result = dynamics.cycle(state.specimen, wall_control(stage(), state.aim, numerics));
  ++dynamic.calm.cycle;
  dynamic.ripple = std::max(dynamic.ripple, off_target(stage(), state.aim, state.specimen));
  const double deviation = watch_stress(state.aim, stage(), state.specimen, numerics);
  if (!computed(result, batch)) return;
  watch_calm(dynamic.calm, deviation, !result.failures.empty(), numerics);
  if (dynamic.calm.on_target) {
    batch.outcome = servo_guard(off_target(stage(), state.aim, state.specimen));
    if (batch.outcome) return;
  }
  if (numerics.drift_tolerance) {
    watch_failure_times(dynamic, state.specimen, experiment, next_breakages(), time_left());
  }
  const std::int64_t most = most_cycles(numerics), cycle = dynamic.calm.cycle;
  const double strain = axial_strain(state.specimen);
  if (cycle == most / 2) dynamic.strain_half_way = strain;

  const double creep_strain = strain - state.hold->start.axial_strain;
  if (creep_strain > kCreepFailureStrain) {
    fail_in_creep(dynamic, absl::StrCat("axial creep strain ", creep_strain, " > ", kCreepFailureStrain),
                  batch);
  } else if (cycle >= numerics.minimum_cycles && at_rest(dynamic.calm, state.specimen, numerics) &&
             failure_times_stand(dynamic, numerics) && contacts_carry_the_walls(dynamic.calm)) {
    end_dynamic_stage(dynamic, true, batch);
  } else if (cycle >= most) {
    const double flow = strain - dynamic.strain_half_way.value_or(strain);
    const std::string where = absl::StrCat("dynamic stage ", dynamic_stage_number(state));
    if (state.aim.sides == Aim::Sides::kHeld && flow > kUnsettledStrain) {
      fail_in_creep(dynamic,
                    absl::StrCat(where, " flows, axial strain ", flow, " in its last ", most / 2, " cycles"),
                    batch);
    } else {
      end_dynamic_stage(dynamic, false, batch);
      give_up_settling(dynamic.calm, where, batch);
    }
  }
}

void Run::Impl::fail_in_creep(DynamicStage& dynamic, const std::string& how, Batch& batch) {
  end_dynamic_stage(dynamic, false, batch);
  batch.outcome = {Outcome::Kind::kCreepFailure, absl::StrCat("creep failure: ", how), ""};
  state.act = Done{true};
}

void Run::Impl::end_dynamic_stage(DynamicStage& dynamic, bool settled, Batch& batch) {
  Hold& hold = *state.hold;
  if (hold.ageing_jumps > 0) hold.largest_ripple = std::max(hold.largest_ripple, dynamic.ripple);
  ++hold.dynamic_stages;
  emit_sample(Phase::kDynamicStage, batch);
  emit(RecordKind::kStage, stage_values(state, dynamic, settled, experiment), batch);
  emit_grading(batch);
  batch.stage_ended = true;
  const bool hold_ends = !settled || dynamic.closing || time_left() <= 0.0;
  if (passes_decade_of_age(hold, state.specimen.clocks) || hold_ends) emit_snapshot(batch);
  if (!settled) return;
  if (hold_ends) {
    next_stage(batch);
  } else {
    state.act = Ageing{};
  }
}

void Run::Impl::step(Ageing&, Batch& batch) {
  const Doing ageing(options.activity, Activity::kAgeing);
  dynamics.assess(state.specimen);
  const double left = time_left();
  if (experiment.numerics.ageing_error_tolerance) adapt_breakages(*state.hold, left, state, experiment);
  const AgeingJump jump = age(state.specimen, experiment.material, next_breakages(), left);
  ++state.hold->ageing_jumps;
  emit_sample(Phase::kAgeing, batch);
  break_particles(jump.failures, batch);
  state.act = new_dynamic_stage(static_cast<std::int64_t>(jump.failures.size()), jump.reached_end);
}

}  // namespace creep
