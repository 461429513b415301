// What a Run is inside: the experiment, the machine that moves the particles and the state; for the sources
// of Run alone. The plot is in run.cpp, each act in a file of its own.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/dem/dynamics.h"
#include "core/run/run.h"
#include "core/run/self_test.h"
#include "core/state/checkpoint.h"
#include "core/state/state.h"

namespace creep {

constexpr const char* kPackingWord = "packing";

struct Run::Impl {
  Impl(const Experiment& asked, const Kernels& kernels, const RunOptions& options)
      : experiment(asked),
        options(options),
        dynamics(experiment, kernels, {options.threads, options.rebuild_every, options.activity}) {}

  // The plot. One step of an act may end it: what it was given is gone then.
  Batch advance(std::int64_t cycle_budget);
  void step(PackingState& packing, Batch& batch);
  void step(Starting& starting, Batch& batch);
  void step(Loading& loading, Batch& batch);
  void step(DynamicStage& stage, Batch& batch);
  void step(Ageing& ageing, Batch& batch);
  void step(Between& between, Batch& batch);
  void step(Done& done, Batch& batch);
  void begin_program(Batch& batch);
  void begin_stage(std::int64_t index);
  void next_stage(Batch& batch);
  const Stage& stage() const { return experiment.program[static_cast<std::size_t>(state.stage)]; }

  // Loading.
  Loading new_loading() const;
  void end_loading(const Loading& loading, bool settled, Batch& batch);
  void keep_if_due(Loading& loading, Batch& batch) const;

  // Hold.
  Hold new_hold() const;
  DynamicStage new_dynamic_stage(std::int64_t broken_at_start, bool closing) const;
  void end_dynamic_stage(DynamicStage& stage, bool settled, Batch& batch);
  void fail_in_creep(DynamicStage& stage, const std::string& how, Batch& batch);
  std::int64_t next_breakages() const;
  double time_left() const;

  // What both do.
  bool computed(const CycleResult& result, Batch& batch);
  bool energy_grows(Batch& batch) const;
  void break_particles(const std::vector<Failure>& failures, Batch& batch);
  bool contacts_carry_the_walls(Calm& calm);
  void give_up_settling(const Calm& calm, const std::string& where, Batch& batch);

  // What leaves the run (emission.cpp).
  void emit(RecordKind kind, std::vector<double> values, Batch& batch);
  void emit_sample(Phase phase, Batch& batch);
  void emit_grading(Batch& batch);
  /// Right after a sample, while the list is valid.
  void emit_snapshot(Batch& batch) const;
  void keep(std::optional<std::int64_t> multiple, Batch& batch) const;
  std::string checkpoint() const;
  std::string stage_word() const;
  Progress progress() const;

  const Experiment experiment;
  const RunOptions options;
  const std::string arithmetic = arithmetic_id(options.instruction_set);
  Dynamics dynamics;
  RunState state;
};

/// Of samples taken now.
Phase phase_of(const Act& act);

}  // namespace creep
