// How a run begins, is left in a checkpoint, and begins again from one.
#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "core/dem/measures.h"
#include "core/dem/packing.h"
#include "core/dem/particle_birth.h"
#include "core/output/samples.h"
#include "core/run/run_impl.h"

namespace creep {
namespace {

/// Whether the cursor stands where the program has what it does.
bool stands_in(const std::vector<Stage>& program, const Cursor& cursor) {
  const auto size = static_cast<std::int64_t>(program.size());
  if (cursor.stage >= size) return false;
  const Stage* stage = cursor.stage < 0 ? nullptr : &program[static_cast<std::size_t>(cursor.stage)];
  switch (cursor.act) {
    case Cursor::Act::kPacking:
    case Cursor::Act::kStart:
      return true;
    case Cursor::Act::kLoading:
      return stage != nullptr && target_of(*stage) != nullptr;
    case Cursor::Act::kDynamicStage:
    case Cursor::Act::kAgeing:
      return stage != nullptr && duration_of(*stage).has_value();
    case Cursor::Act::kBetweenStages:
      return stage != nullptr && cursor.stage + 1 < size;
    case Cursor::Act::kDone:
      return false;
  }
  return false;
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
  state.packing = source->packing;
  const Cursor& before = source->cursor;
  state.cursor.act = Cursor::Act::kStart;
  state.cursor.initial_count = before.initial_count;
  state.cursor.void_ratio_reached = before.void_ratio_reached;
  state.cursor.void_ratio_loaded = before.void_ratio_loaded;
  state.cursor.initial_grading_index = before.initial_grading_index;
  state.cursor.sides = before.sides;
  state.cursor.radial_target = before.radial_target;
  state.cursor.target = before.act == Cursor::Act::kLoading ? state.specimen.walls.stress(2) : before.target;
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
  const bool rubs = experiment.material.wall_friction > 0.0 && state->cursor.act != Cursor::Act::kPacking;
  if (state->specimen.particles.wall_shear.empty() == rubs) {
    return absl::DataLossError(
        "this checkpoint has no friction at walls where the experiment has, or the other way round");
  }
  if (!stands_in(experiment.program, state->cursor)) {
    return absl::DataLossError("this checkpoint does not stand in the program of its experiment");
  }
  auto impl = std::make_unique<Impl>(experiment, **kernels, options);
  impl->state = *std::move(state);
  impl->state.inexact = impl->state.inexact || !same;
  return std::unique_ptr<Run>(new Run(std::move(impl)));
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
  info.finished = state.cursor.act == Cursor::Act::kDone;
  return write_checkpoint(state, info);
}

std::string Run::checkpoint() const { return impl_->checkpoint(); }
}  // namespace creep
