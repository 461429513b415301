// How a run begins, and begins again from a checkpoint.
#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "core/dem/packing.h"
#include "core/dem/particle_birth.h"
#include "core/run/run_impl.h"

namespace creep {
namespace {

/// Whether the program has, at this place, what the run does.
bool stands_in(const std::vector<Stage>& program, const RunState& state) {
  const auto size = static_cast<std::int64_t>(program.size());
  if (state.stage >= size) return false;
  const Stage* stage = state.stage < 0 ? nullptr : &program[static_cast<std::size_t>(state.stage)];
  const bool loads = stage != nullptr && target_of(*stage) != nullptr;
  const bool holds = stage != nullptr && duration_of(*stage).has_value();
  struct Standing {
    bool loads, holds, is_last;
    bool operator()(const PackingState&) const { return true; }
    bool operator()(const Starting&) const { return true; }
    bool operator()(const Loading&) const { return loads; }
    bool operator()(const DynamicStage&) const { return holds; }
    bool operator()(const Ageing&) const { return holds; }
    bool operator()(const Between&) const { return (loads || holds) && !is_last; }
    bool operator()(const Done&) const { return false; }
  };
  return std::visit(Standing{loads, holds, state.stage + 1 == size}, state.act);
}

}  // namespace

absl::StatusOr<std::unique_ptr<Run>> Run::start(const Experiment& experiment, const RunOptions& options) {
  const absl::StatusOr<const Kernels*> kernels = kernels_for(options.instruction_set);
  if (!kernels.ok()) return kernels.status();
  if (experiment.start) {
    return absl::InvalidArgumentError("the job starts from a checkpoint, and none was given to it");
  }
  auto impl = std::make_unique<Impl>(experiment, **kernels, options);
  impl->state.specimen = scatter(experiment);
  return std::unique_ptr<Run>(new Run(std::move(impl)));
}

absl::StatusOr<std::unique_ptr<Run>> Run::start_from(const Experiment& experiment, const RunOptions& options,
                                                     std::string_view checkpoint) {
  const absl::StatusOr<const Kernels*> kernels = kernels_for(options.instruction_set);
  if (!kernels.ok()) return kernels.status();
  const absl::StatusOr<CheckpointInfo> info = read_checkpoint_info(checkpoint);
  if (!info.ok()) return info.status();
  if (absl::Status status = can_start_from(*info, specimen_hash(experiment)); !status.ok()) return status;
  absl::StatusOr<RunState> source = read_checkpoint(checkpoint);
  if (!source.ok()) return source.status();
  auto impl = std::make_unique<Impl>(experiment, **kernels, options);
  RunState& state = impl->state;
  state.specimen = std::move(source->specimen);
  state.specimen.friction = experiment.material.friction;
  Particles& particles = state.specimen.particles;
  if (particles.spin.empty() == experiment.material.free_rotation) {  // set free or blocked from here on
    particles.spin.assign(experiment.material.free_rotation ? particles.size() : 0, Spin{});
  }
  let_walls_rub(particles, experiment.material);
  state.act = Starting{};
  state.packed = source->packed;
  state.aim = source->aim;
  if (std::holds_alternative<Loading>(source->act)) state.aim.axial = state.specimen.walls.stress(2);
  state.start_digest = info->state_digest;
  state.inexact = source->inexact;
  return std::unique_ptr<Run>(new Run(std::move(impl)));
}

absl::Status can_start_from(const CheckpointInfo& info, std::string_view specimen_hash) {
  if (info.stage == kPackingWord) {
    return absl::InvalidArgumentError(
        "the checkpoint to start from is of a specimen that is still being packed");
  }
  if (info.specimen_hash == specimen_hash) return absl::OkStatus();
  if (info.specimen_hash.empty()) {
    return absl::InvalidArgumentError(
        "the checkpoint to start from was made by an earlier version: it can be continued only");
  }
  return absl::InvalidArgumentError(
      "the checkpoint to start from has another specimen: [specimen], density, strength, comminution_limit "
      "and "
      "inertia_scaling must be those of its job");
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
  if (info->finished) {
    return absl::InvalidArgumentError("this checkpoint is of the end of its program: start another from it");
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
  if (state->specimen.particles.spin.empty() == experiment.material.free_rotation) {
    return absl::DataLossError(
        "this checkpoint has no spins where the experiment has, or the other way round");
  }
  const bool rubs =
      experiment.material.wall_friction > 0.0 && !std::holds_alternative<PackingState>(state->act);
  if (state->specimen.particles.wall_shear.empty() == rubs) {
    return absl::DataLossError(
        "this checkpoint has no friction at walls where the experiment has, or the other way round");
  }
  if (!stands_in(experiment.program, *state)) {
    return absl::DataLossError("this checkpoint does not stand in the program of its experiment");
  }
  auto impl = std::make_unique<Impl>(experiment, **kernels, options);
  impl->state = *std::move(state);
  impl->state.inexact = impl->state.inexact || !same;
  return std::unique_ptr<Run>(new Run(std::move(impl)));
}

}  // namespace creep
