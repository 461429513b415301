#include "core/experiment/fidelity.h"
#include "core/run/run_impl.h"

#include <algorithm>
#include <cmath>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "core/arithmetic/check.h"
#include "core/arithmetic/elementary.h"
#include "core/dem/dynamics.h"
#include "core/dem/measures.h"
#include "core/dem/packing.h"
#include "core/dem/particle_birth.h"
#include "core/dem/splitter.h"
#include "core/experiment/stage_text.h"
#include "core/output/samples.h"
#include "core/output/snapshot.h"
#include "core/run/ageing.h"
#include "core/run/guards.h"
#include "core/run/self_test.h"
#include "core/run/stage_control.h"
#include "core/state/state.h"

namespace creep {
namespace {

constexpr std::int64_t kSampleInterval = 2000;  // cycles
constexpr double kSampleStressRatio = 1.05;     // between samples of loading: even steps of log stress
constexpr double kSampleStrain = 0.002;         // the same of loading by strain
constexpr double kCreepFailureStrain = 0.2;     // axial creep strain
constexpr double kUnsettledStrain = 1e-3;       // in the second half of a stage: it flows, it does not settle
constexpr double kVoidRatioTolerance = 0.002;

}  // namespace

Batch Run::Impl::advance(std::int64_t cycle_budget) {
  Batch batch;
  const std::int64_t first_cycle = state.specimen.cycle;
  const std::int64_t first_search = dynamics.searches();
  dynamics.let_fail(state.cursor.act != Cursor::Act::kPacking);
  while (!batch.stage_ended && !batch.outcome &&
         state.specimen.cycle - first_cycle < std::max<std::int64_t>(1, cycle_budget)) {
    batch.particle_steps += static_cast<double>(state.specimen.particles.size());
    switch (state.cursor.act) {
      case Cursor::Act::kPacking:
        pack(batch);
        break;
      case Cursor::Act::kStart:
        begin_program(batch);
        break;
      case Cursor::Act::kBetweenStages:
        begin_stage(state.cursor.stage + 1);
        break;
      case Cursor::Act::kLoading:
        load(batch);
        break;
      case Cursor::Act::kDynamicStage:
        hold(batch);
        break;
      case Cursor::Act::kAgeing:
        age_and_break(batch);
        break;
      case Cursor::Act::kDone:
        CREEP_CHECK(false, "advance() after the outcome");
    }
  }
  batch.cycles = state.specimen.cycle - first_cycle;
  batch.rebuilds = dynamics.searches() - first_search;
  return batch;
}

void Run::Impl::pack(Batch& batch) {
  const PackingFault fault = pack_one_cycle(state.specimen, state.packing, experiment, dynamics);
  if (!fault.empty()) {
    batch.outcome = guard_stop(fault, "give a void ratio that this grading can reach, or another seed");
    return;
  }
  if (state.packing.step != PackingState::Step::kDone) {
    if (state.specimen.cycle % kSampleInterval == 0) emit_sample(Phase::kPacking, batch);
    return;
  }
  Cursor& cursor = state.cursor;
  cursor.initial_count = static_cast<std::int64_t>(state.specimen.particles.size());
  cursor.void_ratio_reached = void_ratio(state.specimen, experiment.material.density).with_fines;
  cursor.initial_grading_index = grading_index(state.specimen, experiment.material);
  cursor.sides = Cursor::Sides::kHeld;
  cursor.target = cursor.radial_target = experiment.specimen.isotropic_stress;
  let_walls_rub(state.specimen.particles, experiment.material);
  emit_sample(Phase::kPacking, batch);
  begin_program(batch);
}

void Run::Impl::begin_program(Batch& batch) {
  if (scale_inertia(state.specimen, experiment)) dynamics.assess(state.specimen);
  if (state.cursor.act == Cursor::Act::kStart) emit_sample(Phase::kLoading, batch);
  emit_grading(batch);
  emit_snapshot(batch);
  begin_stage(0);
  batch.stage_ended = true;
}

void Run::Impl::begin_stage(std::int64_t index) {
  Cursor& cursor = state.cursor;
  cursor.stage = index;
  cursor.kept = steps_passed();
  cursor.dynamic_stage = 0;
  take_aim(cursor, stage(), state.specimen);
  target_of(stage()) != nullptr ? begin_loading() : begin_hold();
}

void Run::Impl::begin_loading() {
  Cursor& cursor = state.cursor;
  cursor.act = Cursor::Act::kLoading;
  cursor.holding = false;
  cursor.stage_cycle = 0;
  cursor.quiet_since = 0;
  cursor.reached_cycle = -1;
  cursor.loading_start = value_of(target_of(stage())->measure, state.specimen);
  cursor.sample_at = 0.0;
  cursor.broken_at_start = 0;
  cursor.broken_before = state.specimen.broken_total;
  cursor.creep_time_start = 0.0;
  cursor.suspended_start = state.specimen.clocks.suspended_time;
}

void Run::Impl::begin_hold() {
  Cursor& cursor = state.cursor;
  cursor.holding = true;
  state.specimen.clocks.hold_start = state.specimen.clocks.age + state.specimen.clocks.dynamic_time;
  cursor.age_loaded = state.specimen.clocks.age;
  cursor.next_snapshot_age = Cursor::kFirstSnapshotAge;
  cursor.strain_loaded = axial_strain(state.specimen);
  cursor.stress_loaded = state.specimen.walls.stress(2);
  cursor.broken_loaded = state.specimen.broken_total;
  cursor.dynamic_stages = 0;
  cursor.ageing_jumps = 0;
  cursor.largest_ripple = 0.0;
  cursor.closing = false;
  cursor.breakages = breakages_per_ageing(experiment.numerics, cursor.initial_count);
  cursor.aged_from = 0.0;
  begin_dynamic_stage(0);
}

void Run::Impl::begin_dynamic_stage(std::int64_t broken_at_start) {
  Cursor& cursor = state.cursor;
  cursor.act = Cursor::Act::kDynamicStage;
  cursor.stage_cycle = 0;
  cursor.quiet_since = 0;
  cursor.ripple = 0.0;
  cursor.reached_cycle = -1;
  cursor.drift_cycle = 0;
  cursor.drift = -1.0;
  cursor.creep_time_start = state.specimen.clocks.creep_time();
  cursor.suspended_start = state.specimen.clocks.suspended_time;
  cursor.broken_at_start = broken_at_start;
  cursor.broken_before = state.specimen.broken_total;
}

bool Run::Impl::computed(const CycleResult& result, Batch& batch) {
  ++state.cursor.stage_cycle;
  if (auto stop = cycle_guard(result)) {
    batch.outcome = std::move(stop);
    return false;
  }
  break_particles(result.failures, batch);
  if (state.specimen.cycle % kSampleInterval != 0) return true;
  emit_sample(phase(), batch);
  return !energy_grows(batch);
}

/// By the sample just made.
bool Run::Impl::energy_grows(Batch& batch) const {
  const std::vector<double>& sample = batch.records.back().values;
  batch.outcome =
      energy_guard(state.specimen.energy, sample[column_index(RecordKind::kSample, "energy_unexplained_J")]);
  return batch.outcome.has_value();
}

bool Run::Impl::servo_runs_away(double deviation, Batch& batch) {
  Cursor& cursor = state.cursor;
  if (deviation < experiment.numerics.settle_tolerance && cursor.reached_cycle < 0)
    cursor.reached_cycle = cursor.stage_cycle;
  if (cursor.reached_cycle < 0) return false;
  batch.outcome = servo_guard(off_target(stage(), cursor, state.specimen));
  return batch.outcome.has_value();
}

void Run::Impl::break_particles(const std::vector<Failure>& failures, Batch& batch) {
  if (failures.empty()) return;
  const Doing breaking(options.activity, Activity::kBreaking);
  for (const Failure& failure : failures) emit(RecordKind::kBreakage, breakage_values(state, failure), batch);
  split(state.specimen, experiment, dynamics, failures);
}

void Run::Impl::load(Batch& batch) {
  Cursor& cursor = state.cursor;
  WallControl control = wall_control(stage(), cursor, experiment.numerics);
  if (const auto& limit = experiment.numerics.inertial_number_limit) {
    control[2].closing_velocity =
        std::min(control[2].closing_velocity, closing_velocity_at(*limit, state.specimen, experiment));
  }
  const CycleResult result = dynamics.cycle(state.specimen, control);
  if (!computed(result, batch)) return;
  if (comes_to_rest(stage())) {
    const bool on_target = watch_stress() < experiment.numerics.settle_tolerance;
    if (!on_target || !result.failures.empty()) cursor.quiet_since = cursor.stage_cycle;
    if (on_target && cursor.reached_cycle < 0) cursor.reached_cycle = cursor.stage_cycle;
    if (at_rest()) return end_loading(batch, true);
    if (cursor.reached_cycle >= 0 && cursor.stage_cycle - cursor.reached_cycle >= most_cycles()) {
      end_loading(batch, false);
      return give_up_settling(batch);
    }
  } else if (has_passed(stage(), cursor, state.specimen, experiment.numerics.settle_tolerance)) {
    return end_loading(batch, true);
  }
  batch.outcome = loading_guard(state.specimen, experiment, *target_of(stage()));
  if (batch.outcome) return;
  if (loading_sample_is_due()) emit_sample(Phase::kLoading, batch);
  keep_if_due(batch);
}

void Run::Impl::end_loading(Batch& batch, bool settled) {
  keep_aim(state.cursor, stage(), state.specimen);
  state.cursor.void_ratio_loaded = void_ratio(state.specimen, experiment.material.density).with_fines;
  emit_sample(Phase::kLoading, batch);
  // A stress that leaps past its target because the step is unstable is no end of loading.
  if (energy_grows(batch)) return;
  emit(RecordKind::kStage, stage_values(state, experiment, settled), batch);
  emit_grading(batch);
  emit_snapshot(batch);
  if (settled) next_stage(batch);
}

bool Run::Impl::loading_sample_is_due() {
  double& at = state.cursor.sample_at;
  const double stress = state.specimen.walls.stress(2);
  if (std::holds_alternative<UnloadStage>(stage())) {
    if (at != 0.0 && stress > at) return false;
    at = stress / kSampleStressRatio;
  } else if (std::holds_alternative<TriaxialStage>(stage())) {
    const double strain = axial_strain(state.specimen);
    if (at != 0.0 && strain < at) return false;
    at = strain + kSampleStrain;
  } else {
    if (stress < at) return false;
    at = kSampleStressRatio * stress;
  }
  return true;
}

/// How far off target the walls are that hold a stress. A relaxation is compared with its own stress: it has
/// settled once that stands still.
double Run::Impl::watch_stress() {
  Cursor& cursor = state.cursor;
  const double deviation = off_target(stage(), cursor, state.specimen);
  cursor.ripple = std::max(cursor.ripple, deviation);
  if (!std::holds_alternative<RelaxationStage>(stage())) return deviation;
  const double stress = state.specimen.walls.stress(2);
  const double change = std::fabs(stress - cursor.target) / std::max(stress, cursor.target);
  if (change >= experiment.numerics.settle_tolerance) cursor.target = stress;
  return std::max(deviation, change);
}

std::int64_t Run::Impl::next_breakages() const {
  return experiment.numerics.ageing_error_tolerance
             ? state.cursor.breakages
             : breakages_per_ageing(experiment.numerics, state.cursor.initial_count);
}

/// Once a window, in a cycle that measured: sigma_mob is not in a checkpoint.
void Run::Impl::watch_failure_times() {
  Cursor& cursor = state.cursor;
  if ((state.specimen.cycle - 1) % Dynamics::kMeasureInterval != 0 ||
      cursor.stage_cycle - cursor.drift_cycle < settle_window()) {
    return;
  }
  const double now = state.specimen.clocks.creep_time();
  const double next = time_to_failures(state.specimen, experiment.material, next_breakages());
  const double end = log_end_of_ageing(now, next, std::max(0.0, *duration_of(stage()) - now));
  cursor.drift = cursor.drift_cycle > 0 ? std::fabs(end - cursor.drift_reference) : -1.0;
  cursor.drift_reference = end;
  cursor.drift_cycle = cursor.stage_cycle;
}

bool Run::Impl::failure_times_stand() const {
  const auto& tolerance = experiment.numerics.drift_tolerance;
  return !tolerance || (state.cursor.drift >= 0.0 && state.cursor.drift < *tolerance);
}

bool Run::Impl::at_rest() const {
  const Cursor& cursor = state.cursor;
  return cursor.stage_cycle - cursor.quiet_since >= settle_window() &&
         state.specimen.unbalanced_force_ratio < experiment.numerics.unbalanced_tolerance;
}

void Run::Impl::hold(Batch& batch) {
  Cursor& cursor = state.cursor;
  const Numerics& numerics = experiment.numerics;
  const CycleResult result = dynamics.cycle(state.specimen, wall_control(stage(), cursor, numerics));
  const double deviation = watch_stress();
  if (!computed(result, batch) || servo_runs_away(deviation, batch)) return;
  if (deviation >= numerics.settle_tolerance || !result.failures.empty())
    cursor.quiet_since = cursor.stage_cycle;
  if (numerics.drift_tolerance) watch_failure_times();
  if (cursor.stage_cycle == most_cycles() / 2) cursor.strain_half_way = axial_strain(state.specimen);

  const double creep_strain = axial_strain(state.specimen) - cursor.strain_loaded;
  if (creep_strain > kCreepFailureStrain) {
    fail_in_creep(absl::StrCat("axial creep strain ", creep_strain, " > ", kCreepFailureStrain), batch);
  } else if (cursor.stage_cycle >= numerics.minimum_cycles && at_rest() && failure_times_stand()) {
    end_dynamic_stage(batch, true);
  } else if (cursor.stage_cycle >= most_cycles()) {
    const double flow = axial_strain(state.specimen) - cursor.strain_half_way;
    if (cursor.sides == Cursor::Sides::kHeld && flow > kUnsettledStrain) {
      fail_in_creep(absl::StrCat("dynamic stage ", cursor.dynamic_stage, " flows, axial strain ", flow,
                                 " in its last ", most_cycles() / 2, " cycles"),
                    batch);
    } else {
      end_dynamic_stage(batch, false);
      give_up_settling(batch);
    }
  }
}

void Run::Impl::fail_in_creep(const std::string& how, Batch& batch) {
  end_dynamic_stage(batch, false);
  batch.outcome = {Outcome::Kind::kCreepFailure, absl::StrCat("creep failure: ", how), ""};
  state.cursor.act = Cursor::Act::kDone;
}

void Run::Impl::give_up_settling(Batch& batch) {
  const Cursor& cursor = state.cursor;
  const std::string where = cursor.holding ? absl::StrCat("dynamic stage ", cursor.dynamic_stage)
                                           : absl::StrCat(std::string(stage_name(stage())), " stage");
  batch.outcome = settling_stop(where, cursor, state.specimen);
}

void Run::Impl::end_dynamic_stage(Batch& batch, bool settled) {
  Cursor& cursor = state.cursor;
  if (cursor.dynamic_stage > 0) cursor.largest_ripple = std::max(cursor.largest_ripple, cursor.ripple);
  ++cursor.dynamic_stages;
  emit_sample(Phase::kDynamicStage, batch);
  emit(RecordKind::kStage, stage_values(state, experiment, settled), batch);
  emit_grading(batch);
  batch.stage_ended = true;
  const bool hold_ends =
      !settled || cursor.closing || state.specimen.clocks.creep_time() >= *duration_of(stage());
  if (passes_decade_of_age() || hold_ends) emit_snapshot(batch);
  if (!settled) return;
  if (hold_ends) {
    next_stage(batch);
  } else {
    cursor.act = Cursor::Act::kAgeing;
  }
}

/// From the last jump to the n_age of this one, and what this one promises.
void Run::Impl::adapt_breakages(double left) {
  Cursor& cursor = state.cursor;
  const double now = state.specimen.clocks.creep_time();
  const auto wait = [&](std::int64_t wanted) {
    return time_to_failures(state.specimen, experiment.material, wanted);
  };
  if (cursor.aged_from > 0.0) {
    const double error =
        relative_strain_error({cursor.aged_from, now, cursor.promised, wait(cursor.breakages), left});
    cursor.breakages = adapted_breakages(cursor.breakages, error, *experiment.numerics.ageing_error_tolerance,
                                         cursor.initial_count);
  }
  const double once = std::min(wait(cursor.breakages), left);
  cursor.promised = std::max(0.0, wait(2 * cursor.breakages) - once);
  cursor.aged_from = now;
}

void Run::Impl::age_and_break(Batch& batch) {
  const Doing ageing(options.activity, Activity::kAgeing);
  Cursor& cursor = state.cursor;
  dynamics.assess(state.specimen);
  const double left = *duration_of(stage()) - state.specimen.clocks.creep_time();
  if (experiment.numerics.ageing_error_tolerance) adapt_breakages(left);
  const AgeingJump jump = age(state.specimen, experiment.material, next_breakages(), left);
  ++cursor.ageing_jumps;
  ++cursor.dynamic_stage;
  cursor.closing = jump.reached_end;
  emit_sample(Phase::kAgeing, batch);
  break_particles(jump.failures, batch);
  begin_dynamic_stage(static_cast<std::int64_t>(jump.failures.size()));
}

void Run::Impl::next_stage(Batch& batch) {
  const bool last = static_cast<std::size_t>(state.cursor.stage) + 1 == experiment.program.size();
  state.cursor.act = last ? Cursor::Act::kDone : Cursor::Act::kBetweenStages;
  batch.stage_ended = true;
  if (keep_of(stage())) keep(std::nullopt, batch);
  if (last) batch.outcome = Outcome{Outcome::Kind::kCompleted, "completed", ""};
}

/// Multiples of the step to keep at or below the present value; when unloading, at or above it.
std::int64_t Run::Impl::steps_passed() const {
  const std::optional<Keep>& keep = keep_of(stage());
  if (!keep || keep->step == 0.0) return 0;
  const double steps = value_of(keep->measure, state.specimen) / keep->step;
  return static_cast<std::int64_t>(std::holds_alternative<UnloadStage>(stage()) ? std::ceil(steps)
                                                                                : std::floor(steps));
}

void Run::Impl::keep_if_due(Batch& batch) {
  const std::int64_t passed = steps_passed();
  const bool unloading = std::holds_alternative<UnloadStage>(stage());
  if (unloading ? passed >= state.cursor.kept : passed <= state.cursor.kept) return;
  state.cursor.kept = passed;
  keep(passed, batch);
}

void Run::Impl::keep(std::optional<std::int64_t> multiple, Batch& batch) const {
  const auto place = static_cast<std::size_t>(state.cursor.stage);
  batch.kept.push_back({kept_checkpoint_name(place, stage(), multiple), checkpoint()});
}

Phase Run::Impl::phase() const {
  switch (state.cursor.act) {
    case Cursor::Act::kPacking:
      return Phase::kPacking;
    case Cursor::Act::kLoading:
    case Cursor::Act::kStart:
    case Cursor::Act::kBetweenStages:
      return Phase::kLoading;
    case Cursor::Act::kAgeing:
      return Phase::kAgeing;
    case Cursor::Act::kDynamicStage:
      return Phase::kDynamicStage;
    case Cursor::Act::kDone:
      return state.cursor.holding ? Phase::kDynamicStage : Phase::kLoading;
  }
  return Phase::kPacking;
}

void Run::Impl::emit(RecordKind kind, std::vector<double> values, Batch& batch) {
  CREEP_CHECK(values.size() == columns(kind).size(), "a row does not fit its columns");
  batch.records.push_back({kind, state.next_sequence++, std::move(values)});
}

void Run::Impl::emit_sample(Phase phase, Batch& batch) {
  const Doing measuring(options.activity, Activity::kMeasures);
  Cursor& cursor = state.cursor;
  dynamics.ensure_list(state.specimen);  // measures look at all pairs that touch now
  emit(RecordKind::kSample, sample_values(state, experiment, dynamics.model(), phase), batch);
  if (cursor.act != Cursor::Act::kLoading || !std::holds_alternative<TriaxialStage>(stage())) return;
  const double q = value_of(Target::Measure::kDeviatoricStress, state.specimen);
  if (q <= cursor.peak_deviatoric_stress) return;
  cursor.peak_deviatoric_stress = q;
  cursor.strain_at_peak = axial_strain(state.specimen);
}

void Run::Impl::emit_grading(Batch& batch) {
  const Doing measuring(options.activity, Activity::kMeasures);
  for (std::vector<double>& row : grading_values(state, experiment))
    emit(RecordKind::kGrading, std::move(row), batch);
  ++state.cursor.curves;
}

void Run::Impl::emit_snapshot(Batch& batch) const {
  if (!experiment.output.snapshots_per_decade) return;
  for (Snapshot& snapshot : snapshots(state, experiment, dynamics.model()))
    batch.snapshots.push_back(std::move(snapshot));
}

bool Run::Impl::passes_decade_of_age() {
  // The cursor moves whether or not there are snapshots: output changes no bit of a checkpoint.
  Cursor& cursor = state.cursor;
  const double age = state.specimen.clocks.age - cursor.age_loaded;
  const bool passes = age >= cursor.next_snapshot_age;
  while (age >= cursor.next_snapshot_age) cursor.next_snapshot_age *= 10.0;
  return passes;
}

Run::Run(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Run::~Run() = default;

Batch Run::advance(std::int64_t cycle_budget) { return impl_->advance(cycle_budget); }

std::string Run::Impl::stage_word() const {
  if (state.cursor.act == Cursor::Act::kStart) return "start";
  return state.cursor.stage < 0 ? kPackingWord : std::string(stage_name(stage()));
}

std::string Run::state_digest() const { return digest_of(impl_->state); }
std::uint64_t Run::next_sequence() const { return impl_->state.next_sequence; }
bool Run::inexact() const { return impl_->state.inexact; }

Progress Run::progress() const {
  const RunState& state = impl_->state;
  const Cursor& cursor = state.cursor;
  Progress progress;
  progress.phase = impl_->phase();
  progress.stage_index = cursor.stage;
  progress.stage_count = static_cast<std::int64_t>(impl_->experiment.program.size());
  progress.dynamic_stage = cursor.dynamic_stage;
  progress.particles = static_cast<std::int64_t>(state.specimen.particles.size());
  progress.stage = impl_->stage_word();
  if (cursor.act == Cursor::Act::kStart) return progress;
  if (cursor.stage < 0) {
    progress.stage_fraction = 0.2 * static_cast<double>(state.packing.step);
    return progress;
  }
  const Stage& stage = impl_->stage();
  if (const auto duration = duration_of(stage)) {
    // Stages of a hold come evenly in log time; the first decades before 1 s hold none.
    const double logs = elementary::log(1.0 + state.specimen.clocks.creep_time());
    progress.stage_fraction =
        cursor.act == Cursor::Act::kDone ? 1.0 : logs / elementary::log(1.0 + *duration);
  } else {
    const Target& until = *target_of(stage);
    const double way = until.value - cursor.loading_start;
    progress.stage_fraction =
        way != 0.0 ? (value_of(until.measure, state.specimen) - cursor.loading_start) / way : 1.0;
  }
  progress.stage_fraction = std::clamp(progress.stage_fraction, 0.0, 1.0);
  return progress;
}

std::vector<SummaryFigure> Run::summary() const {
  return summary_figures(impl_->state, impl_->experiment, impl_->dynamics.model());
}

std::vector<std::string> Run::warnings() const {
  std::vector<std::string> warnings;
  const double target = impl_->experiment.specimen.void_ratio;
  const double reached = impl_->state.cursor.void_ratio_reached;
  if (impl_->state.cursor.stage >= 0 && std::fabs(reached - target) > kVoidRatioTolerance) {
    warnings.push_back(absl::StrCat("void ratio ", reached, " reached where ", target, " was asked for: ",
                                    reached > target
                                        ? "the densest state at zero friction (walls loosen a specimen of "
                                          "few particles)"
                                        : "the loosest state that this packing makes"));
  }
  return warnings;
}

}  // namespace creep
