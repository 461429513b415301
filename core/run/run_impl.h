// What a Run is inside: the experiment, the machine that moves the particles and the state; for the sources
// of Run alone.
#pragma once

#include <algorithm>
#include <cstdint>
#include <string>
#include <vector>

#include "core/dem/dynamics.h"
#include "core/run/run.h"
#include "core/run/self_test.h"
#include "core/run/stage_control.h"
#include "core/state/checkpoint.h"
#include "core/state/state.h"

namespace creep {

constexpr std::int64_t kSettleWindow = 5000;   // cycles on target and without a failure that end a stage
constexpr std::int64_t kUnsettledFactor = 10;  // x minimum_cycles: longer than that is not settling
constexpr const char* kPackingWord = "packing";

struct Run::Impl {
  Impl(const Experiment& asked, const Kernels& kernels, const RunOptions& options)
      : experiment(asked),
        options(options),
        dynamics(experiment, kernels, {options.threads, options.rebuild_every, options.activity}) {}

  Batch advance(std::int64_t cycle_budget);
  void pack(Batch& batch);
  void begin_program(Batch& batch);
  void load(Batch& batch);
  void end_loading(Batch& batch, bool settled);
  bool energy_grows(Batch& batch) const;
  bool servo_runs_away(double deviation, Batch& batch);
  bool loading_sample_is_due();
  void hold(Batch& batch);
  double watch_stress();
  bool at_rest() const;
  std::int64_t next_breakages() const;
  void watch_failure_times();
  bool failure_times_stand() const;
  void adapt_breakages(double left);
  void fail_in_creep(const std::string& how, Batch& batch);
  void give_up_settling(Batch& batch);
  void age_and_break(Batch& batch);

  const Stage& stage() const { return experiment.program[static_cast<std::size_t>(state.cursor.stage)]; }
  void begin_stage(std::int64_t index);
  void begin_loading();
  void begin_hold();
  void begin_dynamic_stage(std::int64_t broken_at_start);
  void end_dynamic_stage(Batch& batch, bool settled);
  void next_stage(Batch& batch);
  std::int64_t steps_passed() const;
  void keep_if_due(Batch& batch);
  void keep(std::optional<std::int64_t> multiple, Batch& batch) const;
  std::string checkpoint() const;
  std::string stage_word() const;
  bool computed(const CycleResult& result, Batch& batch);
  void break_particles(const std::vector<Failure>& failures, Batch& batch);
  std::int64_t settle_window() const { return std::min(kSettleWindow, experiment.numerics.minimum_cycles); }
  std::int64_t most_cycles() const {
    return kUnsettledFactor * std::max(experiment.numerics.minimum_cycles, kSettleWindow);
  }

  void emit(RecordKind kind, std::vector<double> values, Batch& batch);
  void emit_sample(Phase phase, Batch& batch);
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

}  // namespace creep
