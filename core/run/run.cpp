#include "core/run/run.h"

#include <algorithm>
#include <cmath>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "core/arithmetic/check.h"
#include "core/arithmetic/elementary.h"
#include "core/dem/dynamics.h"
#include "core/dem/measures.h"
#include "core/dem/packing.h"
#include "core/dem/splitter.h"
#include "core/run/ageing.h"
#include "core/run/instruction_set.h"
#include "core/run/samples.h"
#include "core/run/snapshot.h"
#include "core/run/state.h"

namespace creep {
namespace {

constexpr std::int64_t kSampleInterval = 2000;  // cycles
constexpr double kSampleStressRatio = 1.05;     // between samples of loading: even steps of log stress
constexpr std::int64_t kSettleWindow = 5000;    // cycles on target and without a failure that end a stage
constexpr std::int64_t kUnsettledFactor = 10;   // x minimum_cycles: longer than that is not settling
constexpr double kCreepFailureStrain = 0.2;     // axial creep strain
constexpr double kLargestOverlap = 1.0;  // of the smaller radius: its centre reaches the surface of the other
constexpr double kLargestInertialNumber = 0.1;  // of loading: beyond it grains collide rather than bear
constexpr double kLargestLoadingStrain = 0.5;   // axial, before loading is given up
constexpr double kVoidRatioTolerance = 0.002;

Outcome guard(std::string reason, std::string advice) {
  return {Outcome::Kind::kGuardStop, absl::StrCat("guard ", reason), std::move(advice)};
}

}  // namespace

struct Run::Impl {
  Impl(const Experiment& asked, const Kernels& kernels, const RunOptions& options)
      : experiment(asked),
        options(options),
        dynamics(experiment, kernels, {options.threads, options.rebuild_every}) {}

  Batch advance(std::int64_t cycle_budget);
  void pack(Batch& batch);
  void load(Batch& batch);
  void hold(Batch& batch);
  void age_and_break(Batch& batch);

  void begin_stage(std::int64_t stage);
  void begin_dynamic_stage(std::int64_t broken_at_start);
  void end_dynamic_stage(Batch& batch, bool settled);
  void next_stage(Batch& batch);
  bool computed(const CycleResult& result, Batch& batch);
  void break_particles(const std::vector<Failure>& failures, Batch& batch);
  WallControl oedometer() const;

  void emit(RecordKind kind, std::vector<double> values, Batch& batch);
  void emit_sample(Phase phase, Batch& batch) {
    dynamics.ensure_list(state.specimen);  // measures look at all pairs that touch now
    emit(RecordKind::kSample, sample_values(state, experiment, dynamics.model(), phase), batch);
  }
  void emit_grading(Batch& batch);
  /// Right after a sample, while the list is valid.
  void emit_snapshot(Batch& batch) const;
  bool passes_decade_of_age();
  Phase phase() const;

  const Experiment experiment;
  const RunOptions options;
  const std::string arithmetic = arithmetic_id(options.instruction_set);
  Dynamics dynamics;
  RunState state;
};

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
    batch.outcome = guard(fault, "give a void ratio that this grading can reach, or another seed");
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
  emit_sample(Phase::kPacking, batch);
  emit_grading(batch);
  emit_snapshot(batch);
  begin_stage(0);
  batch.stage_ended = true;
}

void Run::Impl::begin_stage(std::int64_t stage) {
  Cursor& cursor = state.cursor;
  cursor.stage = stage;
  const Stage& wanted = experiment.program[static_cast<std::size_t>(stage)];
  if (const auto* loading = std::get_if<OedometricStage>(&wanted)) {
    cursor.act = Cursor::Act::kLoading;
    cursor.target = loading->axial_stress;
    cursor.stage_cycle = 0;
    cursor.sample_stress = 0.0;
    cursor.broken_at_start = 0;
    cursor.broken_before = state.specimen.broken_total;
    cursor.creep_time_start = 0.0;
    cursor.suspended_start = state.specimen.clocks.suspended_time;
    return;
  }
  const auto& creep = std::get<CreepStage>(wanted);
  if (creep.axial_stress) cursor.target = *creep.axial_stress;
  state.specimen.clocks.hold_start = state.specimen.clocks.age + state.specimen.clocks.dynamic_time;
  cursor.age_loaded = state.specimen.clocks.age;
  cursor.next_snapshot_age = Cursor::kFirstSnapshotAge;
  cursor.strain_loaded = axial_strain(state.specimen);
  cursor.broken_loaded = state.specimen.broken_total;
  cursor.dynamic_stage = 0;
  cursor.dynamic_stages = 0;
  cursor.ageing_jumps = 0;
  cursor.largest_ripple = 0.0;
  cursor.closing = false;
  begin_dynamic_stage(0);
}

void Run::Impl::begin_dynamic_stage(std::int64_t broken_at_start) {
  Cursor& cursor = state.cursor;
  cursor.act = Cursor::Act::kDynamicStage;
  cursor.stage_cycle = 0;
  cursor.quiet_since = 0;
  cursor.ripple = 0.0;
  cursor.creep_time_start = state.specimen.clocks.creep_time();
  cursor.suspended_start = state.specimen.clocks.suspended_time;
  cursor.broken_at_start = broken_at_start;
  cursor.broken_before = state.specimen.broken_total;
}

WallControl Run::Impl::oedometer() const {
  WallControl control{};  // sides fixed
  control[2].mode = AxisControl::Mode::kServo;
  control[2].stress = state.cursor.target;
  control[2].closing_velocity = experiment.numerics.loading_velocity;
  return control;
}

bool Run::Impl::computed(const CycleResult& result, Batch& batch) {
  ++state.cursor.stage_cycle;
  if (!result.finite) {
    batch.outcome = guard("non-finite: a position, velocity or force is no longer a number",
                          "lower time_step_safety; the last good checkpoint is kept");
    return false;
  }
  if (result.largest_overlap_ratio > kLargestOverlap) {
    batch.outcome =
        guard(absl::StrCat("overlap: ", result.largest_overlap_ratio, " of the smaller radius, limit ",
                           kLargestOverlap),
              "lower time_step_safety or loading_velocity, or check modulus and stress; the last good "
              "checkpoint is kept");
    return false;
  }
  break_particles(result.failures, batch);
  if (state.specimen.cycle % kSampleInterval == 0) emit_sample(phase(), batch);
  return true;
}

void Run::Impl::break_particles(const std::vector<Failure>& failures, Batch& batch) {
  if (failures.empty()) return;
  for (const Failure& failure : failures) emit(RecordKind::kBreakage, breakage_values(state, failure), batch);
  split(state.specimen, experiment, dynamics, failures);
}

void Run::Impl::load(Batch& batch) {
  const CycleResult result = dynamics.cycle(state.specimen, oedometer());
  if (!computed(result, batch)) return;
  const double stress = state.specimen.walls.stress(2);
  if (stress >= (1.0 - experiment.numerics.settle_tolerance) * state.cursor.target) {
    state.cursor.void_ratio_loaded = void_ratio(state.specimen, experiment.material.density).with_fines;
    emit_sample(Phase::kLoading, batch);
    emit(RecordKind::kStage, stage_values(state, experiment, true), batch);
    emit_grading(batch);
    emit_snapshot(batch);
    next_stage(batch);
  } else if (const double inertia = inertial_number(state.specimen, experiment);
             inertia > kLargestInertialNumber) {
    batch.outcome = guard(
        absl::StrCat("inertia: inertial number ", inertia, " in loading, limit ", kLargestInertialNumber),
        "lower loading_velocity");
  } else if (stress >= state.cursor.sample_stress) {
    emit_sample(Phase::kLoading, batch);
    state.cursor.sample_stress = kSampleStressRatio * stress;
  } else if (axial_strain(state.specimen) > kLargestLoadingStrain) {
    batch.outcome =
        guard(absl::StrCat("loading: axial strain ", kLargestLoadingStrain, " passed at ", stress,
                           " Pa, target ", state.cursor.target, " Pa"),
              "the specimen is too weak for this stress: check limit_stress, d0 and the size exponent");
  }
}

void Run::Impl::hold(Batch& batch) {
  Cursor& cursor = state.cursor;
  const Numerics& numerics = experiment.numerics;
  const CycleResult result = dynamics.cycle(state.specimen, oedometer());
  const double deviation = std::fabs(state.specimen.walls.stress(2) / cursor.target - 1.0);
  cursor.ripple = std::max(cursor.ripple, deviation);
  if (!computed(result, batch)) return;
  if (deviation >= numerics.settle_tolerance || !result.failures.empty())
    cursor.quiet_since = cursor.stage_cycle;

  const std::int64_t window = std::min(kSettleWindow, numerics.minimum_cycles);
  const bool settled = cursor.stage_cycle >= numerics.minimum_cycles &&
                       cursor.stage_cycle - cursor.quiet_since >= window &&
                       state.specimen.unbalanced_force_ratio < numerics.unbalanced_tolerance;
  const double creep_strain = axial_strain(state.specimen) - cursor.strain_loaded;
  if (creep_strain > kCreepFailureStrain) {
    end_dynamic_stage(batch, false);
    batch.outcome = {
        Outcome::Kind::kCreepFailure,
        absl::StrCat("creep failure: axial creep strain ", creep_strain, " > ", kCreepFailureStrain), ""};
    cursor.act = Cursor::Act::kDone;
  } else if (settled) {
    end_dynamic_stage(batch, true);
  } else if (cursor.stage_cycle >= kUnsettledFactor * std::max(numerics.minimum_cycles, kSettleWindow)) {
    end_dynamic_stage(batch, false);
    batch.outcome =
        guard(absl::StrCat("settling: dynamic stage ", cursor.dynamic_stage, " not in equilibrium after ",
                           cursor.stage_cycle, " cycles (unbalanced force ratio ",
                           state.specimen.unbalanced_force_ratio, ", last off target or breaking ",
                           cursor.stage_cycle - cursor.quiet_since, " cycles ago)"),
              "raise minimum_cycles, or loosen unbalanced_tolerance or settle_tolerance");
  }
}

void Run::Impl::end_dynamic_stage(Batch& batch, bool settled) {
  Cursor& cursor = state.cursor;
  if (cursor.dynamic_stage > 0) cursor.largest_ripple = std::max(cursor.largest_ripple, cursor.ripple);
  ++cursor.dynamic_stages;
  emit_sample(Phase::kDynamicStage, batch);
  emit(RecordKind::kStage, stage_values(state, experiment, settled), batch);
  emit_grading(batch);
  batch.stage_ended = true;
  const auto& creep = std::get<CreepStage>(experiment.program[static_cast<std::size_t>(cursor.stage)]);
  const bool hold_ends = !settled || cursor.closing || state.specimen.clocks.creep_time() >= creep.duration;
  if (passes_decade_of_age() || hold_ends) emit_snapshot(batch);
  if (!settled) return;
  if (hold_ends) {
    next_stage(batch);
  } else {
    cursor.act = Cursor::Act::kAgeing;
  }
}

void Run::Impl::age_and_break(Batch& batch) {
  Cursor& cursor = state.cursor;
  dynamics.assess(state.specimen);
  const auto& creep = std::get<CreepStage>(experiment.program[static_cast<std::size_t>(cursor.stage)]);
  const double left = creep.duration - state.specimen.clocks.creep_time();
  const AgeingJump jump = age(state.specimen, experiment.material,
                              breakages_per_ageing(experiment.numerics, cursor.initial_count), left);
  ++cursor.ageing_jumps;
  ++cursor.dynamic_stage;
  cursor.closing = jump.reached_end;
  emit_sample(Phase::kAgeing, batch);
  break_particles(jump.failures, batch);
  begin_dynamic_stage(static_cast<std::int64_t>(jump.failures.size()));
}

void Run::Impl::next_stage(Batch& batch) {
  batch.stage_ended = true;
  if (static_cast<std::size_t>(state.cursor.stage) + 1 < experiment.program.size()) {
    begin_stage(state.cursor.stage + 1);
    return;
  }
  state.cursor.act = Cursor::Act::kDone;
  batch.outcome = Outcome{Outcome::Kind::kCompleted, "completed", ""};
}

Phase Run::Impl::phase() const {
  switch (state.cursor.act) {
    case Cursor::Act::kPacking:
      return Phase::kPacking;
    case Cursor::Act::kLoading:
      return Phase::kLoading;
    case Cursor::Act::kAgeing:
      return Phase::kAgeing;
    case Cursor::Act::kDynamicStage:
    case Cursor::Act::kDone:
      return Phase::kDynamicStage;
  }
  return Phase::kPacking;
}

void Run::Impl::emit(RecordKind kind, std::vector<double> values, Batch& batch) {
  CREEP_CHECK(values.size() == columns(kind).size(), "a row does not fit its columns");
  batch.records.push_back({kind, state.next_sequence++, std::move(values)});
}

void Run::Impl::emit_grading(Batch& batch) {
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

absl::StatusOr<std::unique_ptr<Run>> Run::start(const Experiment& experiment, const RunOptions& options) {
  const absl::StatusOr<const Kernels*> kernels = kernels_for(options.instruction_set);
  if (!kernels.ok()) return kernels.status();
  auto impl = std::make_unique<Impl>(experiment, **kernels, options);
  impl->state.specimen = scatter(experiment);
  return std::unique_ptr<Run>(new Run(std::move(impl)));
}

absl::StatusOr<std::unique_ptr<Run>> Run::resume(const Experiment& experiment, const RunOptions& options,
                                                 std::string_view checkpoint) {
  const absl::StatusOr<const Kernels*> kernels = kernels_for(options.instruction_set);
  if (!kernels.ok()) return kernels.status();
  const absl::StatusOr<CheckpointInfo> info = read_checkpoint_info(checkpoint);
  if (!info.ok()) return info.status();
  if (info->experiment_hash != experiment_hash(experiment)) {
    return absl::InvalidArgumentError("this checkpoint belongs to another experiment");
  }
  const std::string here = arithmetic_id(options.instruction_set);
  const bool same = info->arithmetic_id == here;
  if (!same && !options.allow_inexact) {
    return absl::FailedPreconditionError(absl::StrCat(
        "the checkpoint was computed with arithmetic ", info->arithmetic_id, ", this program has ", here,
        ": the run would not be the same; --allow-inexact continues it all the same and records that"));
  }
  absl::StatusOr<RunState> state = read_checkpoint(checkpoint);
  if (!state.ok()) return state.status();
  if (state->cursor.stage >= static_cast<std::int64_t>(experiment.program.size())) {
    return absl::DataLossError("this checkpoint stands behind the end of the program");
  }
  auto impl = std::make_unique<Impl>(experiment, **kernels, options);
  impl->state = *std::move(state);
  impl->state.inexact = impl->state.inexact || !same;
  return std::unique_ptr<Run>(new Run(std::move(impl)));
}

Batch Run::advance(std::int64_t cycle_budget) { return impl_->advance(cycle_budget); }

std::string Run::checkpoint() const {
  const RunState& state = impl_->state;
  CheckpointInfo info;
  info.arithmetic_id = impl_->arithmetic;
  info.experiment_hash = experiment_hash(impl_->experiment);
  info.state_digest = digest_of(state);
  info.next_sequence = state.next_sequence;
  info.stage = progress().stage;
  info.particles = static_cast<std::int64_t>(state.specimen.particles.size());
  info.cycle = state.specimen.cycle;
  info.age = state.specimen.clocks.age;
  info.dynamic_time = state.specimen.clocks.dynamic_time;
  info.creep_time = creep_time(state);
  info.axial_strain = axial_strain(state.specimen);
  info.broken_total = state.specimen.broken_total;
  info.inexact = state.inexact;
  return write_checkpoint(state, info);
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
  if (cursor.stage < 0) {
    progress.stage = "packing";
    progress.stage_fraction = 0.2 * static_cast<double>(state.packing.step);
    return progress;
  }
  const Stage& stage = impl_->experiment.program[static_cast<std::size_t>(cursor.stage)];
  progress.stage = std::string(stage_name(stage));
  if (const auto* creep = std::get_if<CreepStage>(&stage)) {
    // Stages of a hold come evenly in log time; the first decades before 1 s hold none.
    const double logs = elementary::log(1.0 + state.specimen.clocks.creep_time());
    progress.stage_fraction =
        cursor.act == Cursor::Act::kDone ? 1.0 : logs / elementary::log(1.0 + creep->duration);
  } else {
    progress.stage_fraction = state.specimen.walls.stress(2) / cursor.target;
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
