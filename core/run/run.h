// A run of one experiment, from packing to the end of its program.
//
//   packing -> for each stage: loading (until the stress is reached)
//                              or hold = dynamic stage, then { ageing: age, break; dynamic stage } until the
//                              end
//
// A pull machine: advance() computes up to a budget of cycles and returns what came out. It never calls out,
// prints, opens a file or reads a clock. One thread owns a Run; its kernels use `threads` of their own.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "core/dem/activity.h"
#include "core/experiment/experiment.h"
#include "core/output/outcome.h"
#include "core/output/record.h"
#include "core/output/samples.h"
#include "core/output/snapshot.h"
#include "core/state/checkpoint.h"

namespace creep {

/// What may differ between two attempts at the same experiment without changing a bit of its state.
struct RunOptions {
  int threads = 1;
  std::string instruction_set;  ///< "", "portable", "avx2", "avx512": "" takes the widest the processor has
  bool allow_inexact = false;   ///< resume although arithmetic_id differs
  std::int64_t rebuild_every = 0;    ///< force a neighbour search every so many cycles (tests); 0 = when due
  ActivityMark* activity = nullptr;  ///< where the run marks what it does; must outlive it
};

/// Where the run is, for a progress line.
struct Progress {
  std::string stage;  ///< "packing", "oedometric", "creep"
  Phase phase = Phase::kPacking;
  std::int64_t stage_index = 0;  ///< in the program; -1 while packing
  std::int64_t stage_count = 0;
  std::int64_t dynamic_stage = 0;
  std::int64_t particles = 0;
  double stage_fraction = 0.0;  ///< of the present stage done [0, 1], a rough guess
};

/// A named checkpoint that the program keeps.
struct KeptCheckpoint {
  std::string name;  ///< "02_triaxial_axial_strain_0.015", "02_triaxial_end"; the same in every attempt
  std::string bytes;
};

/// What one advance() brought forth.
struct Batch {
  std::vector<Record> records;       ///< in sequence
  std::vector<Snapshot> snapshots;   ///< in order; none unless the experiment asks for them
  std::vector<KeptCheckpoint> kept;  ///< in order; none unless a stage asks for them
  std::int64_t cycles = 0;           ///< computed now
  double particle_steps = 0.0;       ///< cycles x particles computed now
  std::int64_t rebuilds = 0;  ///< neighbour searches now (depends on skin and schedule, not on the physics)
  bool stage_ended = false;   ///< packing, a program stage or a dynamic stage ended: a checkpoint is due
  std::optional<Outcome> outcome;  ///< set once, at the end
};

class Run {
 public:
  /// A run before its first cycle. Error: InvalidArgument for an unknown or unsupported instruction set.
  /// Or if the experiment has a [start]: that needs start_from().
  static absl::StatusOr<std::unique_ptr<Run>> start(const Experiment& experiment, const RunOptions& options);

  /// Continues from checkpoint() bytes. Errors: DataLoss (damaged), InvalidArgument (another experiment, or
  /// the program is carried out),
  /// FailedPrecondition (other arithmetic_id and not allow_inexact).
  static absl::StatusOr<std::unique_ptr<Run>> resume(const Experiment& experiment, const RunOptions& options,
                                                     std::string_view checkpoint);

  /// Begins the program with the specimen of a checkpoint, of whatever experiment with the same
  /// specimen_hash: program and numerics are the new ones, so are friction, contact law and crack growth.
  /// Strains, ledgers and clocks go on; records begin with 0. Errors: DataLoss (damaged), InvalidArgument
  /// (another specimen, or still packing).
  static absl::StatusOr<std::unique_ptr<Run>> start_from(const Experiment& experiment,
                                                         const RunOptions& options,
                                                         std::string_view checkpoint);
  ~Run();

  /// Computes at most `cycle_budget` cycles (at least 1); stops early at the end of any stage.
  /// After an outcome was returned, must not be called again.
  Batch advance(std::int64_t cycle_budget);

  /// The complete state: resume() with it continues bit for bit.
  std::string checkpoint() const;

  /// SHA-256 (64 hex digits) of the id-ordered physical state (core/README.md, determinism contract, 7).
  std::string state_digest() const;

  Progress progress() const;
  std::vector<SummaryFigure> summary() const;
  std::uint64_t next_sequence() const;
  bool inexact() const;                       ///< was ever resumed with other arithmetic
  std::vector<std::string> warnings() const;  ///< e.g. target void ratio not reached

 private:
  struct Impl;
  explicit Run(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

/// Whether start_from() would take the checkpoint for an experiment of this specimen_hash(). Error:
/// InvalidArgument, with what stands against it.
absl::Status can_start_from(const CheckpointInfo& info, std::string_view specimen_hash);

}  // namespace creep
