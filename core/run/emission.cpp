// What leaves a run: records, snapshots, checkpoints, and where it stands.
#include <algorithm>
#include <utility>

#include "core/arithmetic/check.h"
#include "core/arithmetic/elementary.h"
#include "core/dem/measures.h"
#include "core/experiment/stage_text.h"
#include "core/output/samples.h"
#include "core/output/snapshot.h"
#include "core/run/run_impl.h"
#include "core/run/stage_control.h"

namespace creep {
namespace {

double share_of_way(const Loading& loading, const Target& until, const Specimen& specimen) {
  const double way = until.value - loading.begun_at;
  return way != 0.0 ? (value_of(until.measure, specimen) - loading.begun_at) / way : 1.0;
}

double stage_fraction(const RunState& state, const Experiment& experiment) {
  if (const auto* packing = std::get_if<PackingState>(&state.act)) {
    return 0.2 * static_cast<double>(packing->step);
  }
  if (state.stage < 0) return 0.0;
  const Stage& stage = experiment.program[static_cast<std::size_t>(state.stage)];
  if (const auto duration = duration_of(stage)) {
    // Stages of a hold come evenly in log time; the first decades before 1 s hold none.
    const double logs = elementary::log(1.0 + state.specimen.clocks.creep_time());
    return std::holds_alternative<Done>(state.act) ? 1.0 : logs / elementary::log(1.0 + *duration);
  }
  const auto* loading = std::get_if<Loading>(&state.act);
  return loading != nullptr ? share_of_way(*loading, *target_of(stage), state.specimen) : 1.0;
}

}  // namespace

Phase phase_of(const Act& act) {
  if (std::holds_alternative<PackingState>(act)) return Phase::kPacking;
  if (std::holds_alternative<Ageing>(act)) return Phase::kAgeing;
  const bool dynamic =
      std::holds_alternative<DynamicStage>(act) || (std::holds_alternative<Done>(act) && in_hold(act));
  return dynamic ? Phase::kDynamicStage : Phase::kLoading;
}

void Run::Impl::emit(RecordKind kind, std::vector<double> values, Batch& batch) {
  CREEP_CHECK(values.size() == columns(kind).size(), "a row does not fit its columns");
  batch.records.push_back({kind, state.next_sequence++, std::move(values)});
}

void Run::Impl::emit_sample(Phase phase, Batch& batch) {
  const Doing measuring(options.activity, Activity::kMeasures);
  dynamics.ensure_list(state.specimen);  // measures look at all pairs that touch now
  emit(RecordKind::kSample, sample_values(state, experiment, dynamics.model(), phase), batch);
  if (!std::holds_alternative<Loading>(state.act) || !has_peak(stage())) return;
  const double q = value_of(Target::Measure::kDeviatoricStress, state.specimen);
  if (q > state.peak.deviatoric_stress) state.peak = {q, axial_strain(state.specimen)};
}

void Run::Impl::emit_grading(Batch& batch) {
  const Doing measuring(options.activity, Activity::kMeasures);
  for (std::vector<double>& row : grading_values(state, experiment))
    emit(RecordKind::kGrading, std::move(row), batch);
  ++state.curves;
}

void Run::Impl::emit_snapshot(Batch& batch) const {
  if (!experiment.output.snapshots_per_decade) return;
  for (Snapshot& snapshot : snapshots(state, experiment, dynamics.model()))
    batch.snapshots.push_back(std::move(snapshot));
}

void Run::Impl::keep(std::optional<std::int64_t> multiple, Batch& batch) const {
  const auto place = static_cast<std::size_t>(state.stage);
  batch.kept.push_back({kept_checkpoint_name(place, stage(), multiple), checkpoint()});
}

std::string Run::Impl::stage_word() const {
  if (std::holds_alternative<Starting>(state.act)) return "start";
  return state.stage < 0 ? kPackingWord : std::string(stage_name(stage()));
}

Progress Run::Impl::progress() const {
  Progress progress;
  progress.stage = stage_word();
  progress.phase = phase_of(state.act);
  progress.stage_index = state.stage;
  progress.stage_count = static_cast<std::int64_t>(experiment.program.size());
  progress.dynamic_stage = dynamic_stage_number(state);
  progress.particles = static_cast<std::int64_t>(state.specimen.particles.size());
  progress.stage_fraction = std::clamp(stage_fraction(state, experiment), 0.0, 1.0);
  return progress;
}

std::string Run::Impl::checkpoint() const {
  CheckpointInfo info;
  info.arithmetic_id = arithmetic;
  info.experiment_hash = experiment_hash(experiment);
  info.state_digest = digest_of(state);
  info.next_sequence = state.next_sequence;
  info.stage = stage_word();
  info.particles = static_cast<std::int64_t>(state.specimen.particles.size());
  info.cycle = state.specimen.cycle;
  info.age = state.specimen.clocks.age;
  info.dynamic_time = state.specimen.clocks.dynamic_time;
  info.creep_time = creep_time(state);
  info.axial_strain = axial_strain(state.specimen);
  info.broken_total = state.specimen.broken_total;
  info.inexact = state.inexact;
  info.specimen_hash = specimen_hash(experiment);
  info.start_digest = state.start_digest;
  info.finished = std::holds_alternative<Done>(state.act);
  return write_checkpoint(state, info);
}

}  // namespace creep
