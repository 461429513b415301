// Loading: the walls move until a measure has reached its target.
#include <algorithm>

#include "absl/strings/str_cat.h"
#include "core/dem/measures.h"
#include "core/output/samples.h"
#include "core/run/guards.h"
#include "core/run/run_impl.h"
#include "core/run/settling.h"
#include "core/run/stage_control.h"

namespace creep {

Loading Run::Impl::new_loading() const {
  Loading loading;
  loading.start.suspended_time = state.specimen.clocks.suspended_time;
  loading.start.broken_before = state.specimen.broken_total;
  loading.begun_at = value_of(target_of(stage())->measure, state.specimen);
  loading.kept = steps_passed(stage(), state.specimen);
  return loading;
}

void Run::Impl::step(Loading& loading, Batch& batch) {
  const Numerics& numerics = experiment.numerics;
  WallControl control = wall_control(stage(), state.aim, numerics);
  if (const auto& limit = numerics.inertial_number_limit) {
    control[2].closing_velocity =
        std::min(control[2].closing_velocity, closing_velocity_at(*limit, state.specimen, experiment));
  }
  const CycleResult result = dynamics.cycle(state.specimen, control);
  ++loading.calm.cycle;
  if (!computed(result, batch)) return;
  if (comes_to_rest(stage())) {
    const double deviation = watch_stress(state.aim, stage(), state.specimen, numerics);
    watch_calm(loading.calm, deviation, !result.failures.empty(), numerics);
    if (at_rest(loading.calm, state.specimen, numerics) && contacts_carry_the_walls(loading.calm)) {
      return end_loading(loading, true, batch);
    }
    const auto& since = loading.calm.on_target;
    if (since && loading.calm.cycle - *since >= most_cycles(numerics)) {
      end_loading(loading, false, batch);
      return give_up_settling(loading.calm, absl::StrCat(std::string(stage_name(stage())), " stage"), batch);
    }
  } else if (has_passed(stage(), state.aim, state.specimen, numerics.settle_tolerance)) {
    return end_loading(loading, true, batch);
  }
  batch.outcome = loading_guard(state.specimen, experiment, *target_of(stage()));
  if (batch.outcome) return;
  if (sample_is_due(loading.next_sample, stage(), state.specimen)) emit_sample(Phase::kLoading, batch);
  keep_if_due(loading, batch);
}

void Run::Impl::end_loading(const Loading& loading, bool settled, Batch& batch) {
  keep_aim(state.aim, stage(), state.specimen);
  emit_sample(Phase::kLoading, batch);
  // A stress that leaps past its target because the step is unstable is no end of loading.
  if (energy_grows(batch)) return;
  emit(RecordKind::kStage, stage_values(state, loading, settled, experiment), batch);
  emit_grading(batch);
  emit_snapshot(batch);
  if (settled) next_stage(batch);
}

void Run::Impl::keep_if_due(Loading& loading, Batch& batch) const {
  const std::int64_t passed = steps_passed(stage(), state.specimen);
  if (!goes_beyond(stage(), passed, loading.kept)) return;
  loading.kept = passed;
  keep(passed, batch);
}

}  // namespace creep
