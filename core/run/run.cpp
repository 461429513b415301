#include "core/run/run.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "absl/strings/str_cat.h"
#include "core/arithmetic/check.h"
#include "core/dem/dynamics.h"
#include "core/dem/measures.h"
#include "core/dem/packing.h"
#include "core/dem/particle_birth.h"
#include "core/dem/splitter.h"
#include "core/output/samples.h"
#include "core/run/guards.h"
#include "core/run/run_impl.h"
#include "core/run/settling.h"
#include "core/run/stage_control.h"

namespace creep {
namespace {

constexpr std::int64_t kSampleInterval = 2000;  // cycles
constexpr double kVoidRatioTolerance = 0.002;

}  // namespace

Batch Run::Impl::advance(std::int64_t cycle_budget) {
  Batch batch;
  const std::int64_t first_cycle = state.specimen.cycle;
  const std::int64_t first_search = dynamics.searches();
  dynamics.let_fail(!std::holds_alternative<PackingState>(state.act));
  while (!batch.stage_ended && !batch.outcome &&
         state.specimen.cycle - first_cycle < std::max<std::int64_t>(1, cycle_budget)) {
    batch.particle_steps += static_cast<double>(state.specimen.particles.size());
    std::visit([&](auto& act) { step(act, batch); }, state.act);
  }
  batch.cycles = state.specimen.cycle - first_cycle;
  batch.rebuilds = dynamics.searches() - first_search;
  return batch;
}

void Run::Impl::step(PackingState& packing, Batch& batch) {
  const PackingFault fault = pack_one_cycle(state.specimen, packing, experiment, dynamics);
  if (!fault.empty()) {
    batch.outcome = guard_stop(fault, "give a void ratio that this grading can reach, or another seed");
    return;
  }
  if (packing.step != PackingState::Step::kDone) {
    if (state.specimen.cycle % kSampleInterval == 0) emit_sample(Phase::kPacking, batch);
    return;
  }
  state.packed = Packed{static_cast<std::int64_t>(state.specimen.particles.size()),
                        void_ratio(state.specimen, experiment.material.density).with_fines,
                        grading_index(state.specimen, experiment.material), packing.generation_friction};
  const double stress = experiment.specimen.isotropic_stress;
  state.aim = {Aim::Sides::kHeld, stress, stress};
  let_walls_rub(state.specimen.particles, experiment.material);
  emit_sample(Phase::kPacking, batch);
  begin_program(batch);
}

void Run::Impl::step(Starting&, Batch& batch) { begin_program(batch); }

void Run::Impl::step(Between&, Batch&) { begin_stage(state.stage + 1); }

void Run::Impl::step(Done&, Batch&) { CREEP_CHECK(false, "advance() after the outcome"); }

void Run::Impl::begin_program(Batch& batch) {
  if (scale_inertia(state.specimen, experiment)) dynamics.assess(state.specimen);
  if (std::holds_alternative<Starting>(state.act)) emit_sample(Phase::kLoading, batch);
  emit_grading(batch);
  emit_snapshot(batch);
  begin_stage(0);
  batch.stage_ended = true;
}

void Run::Impl::begin_stage(std::int64_t index) {
  state.stage = index;
  take_aim(state.aim, stage(), state.specimen);
  if (target_of(stage()) != nullptr) {
    state.act = new_loading();
  } else {
    state.hold = new_hold();
    state.specimen.clocks.hold_start = state.specimen.clocks.age + state.specimen.clocks.dynamic_time;
    state.act = new_dynamic_stage(0, false);
  }
}

void Run::Impl::next_stage(Batch& batch) {
  const bool after_hold = in_hold(state.act);
  const bool last = static_cast<std::size_t>(state.stage) + 1 == experiment.program.size();
  state.act = last ? Act(Done{after_hold}) : Act(Between{after_hold});
  batch.stage_ended = true;
  if (keep_of(stage())) keep(std::nullopt, batch);
  if (last) batch.outcome = Outcome{Outcome::Kind::kCompleted, "completed", ""};
}

bool Run::Impl::computed(const CycleResult& result, Batch& batch) {
  if (auto stop = cycle_guard(result)) {
    batch.outcome = std::move(stop);
    return false;
  }
  break_particles(result.failures, batch);
  if (state.specimen.cycle % kSampleInterval != 0) return true;
  emit_sample(phase_of(state.act), batch);
  return !energy_grows(batch);
}

/// By the sample just made.
bool Run::Impl::energy_grows(Batch& batch) const {
  const std::vector<double>& sample = batch.records.back().values;
  batch.outcome =
      energy_guard(state.specimen.energy, sample[column_index(RecordKind::kSample, "energy_unexplained_J")]);
  return batch.outcome.has_value();
}

void Run::Impl::break_particles(const std::vector<Failure>& failures, Batch& batch) {
  if (failures.empty()) return;
  const Doing breaking(options.activity, Activity::kBreaking);
  for (const Failure& failure : failures) emit(RecordKind::kBreakage, breakage_values(state, failure), batch);
  split(state.specimen, experiment, dynamics, failures);
}

/// The last question to a stage at rest: it costs a look at all contacts. If not, another window must pass.
/// Where walls rub, platens and contacts differ by what the sides carry of the axial stress.
bool Run::Impl::contacts_carry_the_walls(Calm& calm) {
  if (experiment.material.wall_friction > 0.0) return true;
  dynamics.ensure_list(state.specimen);
  if (stress_gap(state.specimen, dynamics.model()) < experiment.numerics.settle_tolerance) return true;
  calm.quiet_since = calm.cycle;
  return false;
}

void Run::Impl::give_up_settling(const Calm& calm, const std::string& where, Batch& batch) {
  if (!(experiment.material.wall_friction > 0.0)) {
    batch.outcome =
        stress_guard(where, state.specimen, contact_stress(state.specimen, dynamics.model()),
                     stress_gap(state.specimen, dynamics.model()), experiment.numerics.settle_tolerance);
  }
  if (!batch.outcome) batch.outcome = settling_stop(where, calm, state.specimen);
}

Run::Run(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Run::~Run() = default;

Batch Run::advance(std::int64_t cycle_budget) { return impl_->advance(cycle_budget); }
std::string Run::checkpoint() const { return impl_->checkpoint(); }
std::string Run::state_digest() const { return digest_of(impl_->state); }
std::uint64_t Run::next_sequence() const { return impl_->state.next_sequence; }
bool Run::inexact() const { return impl_->state.inexact; }
Progress Run::progress() const { return impl_->progress(); }

std::vector<SummaryFigure> Run::summary() const {
  return summary_figures(impl_->state, impl_->experiment, impl_->dynamics.model());
}

std::vector<std::string> Run::warnings() const {
  std::vector<std::string> warnings;
  const std::optional<Packed>& packed = impl_->state.packed;
  const double target = impl_->experiment.specimen.void_ratio;
  if (impl_->state.stage >= 0 && packed && std::fabs(packed->void_ratio - target) > kVoidRatioTolerance) {
    warnings.push_back(absl::StrCat(
        "void ratio ", packed->void_ratio, " reached where ", target, " was asked for: ",
        packed->void_ratio > target ? "the densest state at zero friction (walls loosen a specimen of "
                                      "few particles)"
                                    : "the loosest state that this packing makes"));
  }
  return warnings;
}

}  // namespace creep
