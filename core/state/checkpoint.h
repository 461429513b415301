// The state of a run as bytes, whole or not at all.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "absl/status/statusor.h"
#include "core/state/state.h"

namespace creep {

/// What a checkpoint says of itself without being loaded.
struct CheckpointInfo {
  std::uint32_t format_version = 0;
  std::string arithmetic_id;
  std::string experiment_hash;
  std::string state_digest;
  std::uint64_t next_sequence = 0;  ///< of the first record not yet made
  std::string stage;
  std::int64_t particles = 0;
  std::int64_t cycle = 0;     ///< since the start of the run
  double age = 0.0;           ///< [s]
  double dynamic_time = 0.0;  ///< [s]
  double creep_time = 0.0;    ///< [s]
  double axial_strain = 0.0;
  std::int64_t broken_total = 0;
  bool inexact = false;       ///< an attempt was resumed with other arithmetic
  std::string specimen_hash;  ///< what start_from() asks to be equal (experiment.h); "" before version 3
  std::string start_digest;   ///< of the checkpoint that the run itself was started from; "" if it packed
  bool finished = false;      ///< the program is carried out: to start from, not to resume
};

/// Bytes of a checkpoint: magic, version, then named sections, each with its length and checksum.
///
/// To change the format: raise kCheckpointVersion (magic and version keep their places: by them older
/// programs know that they are not to touch the file), keep reading the old one or refuse it by name, and
/// keep an old file among the tests. Version 1, which does not know about snapshots, version 2, which knows
/// only oedometric loading and creep, version 3, in which no particle turns, version 4, in which no wall
/// follows its specimen, version 5, which does not watch failure times, version 6, in which no wall rubs, and
/// version 7, which has one list of fields for every act (format_7.h), are read too.
inline constexpr std::uint32_t kCheckpointVersion = 8;
std::string write_checkpoint(const RunState& state, const CheckpointInfo& info);

/// Errors: FailedPrecondition for one in the format of a newer program, DataLoss for anything else that is
/// not a whole, undamaged checkpoint.
absl::StatusOr<RunState> read_checkpoint(std::string_view bytes);

/// Reads the head, verifies every checksum. Errors: FailedPrecondition (of a newer program), DataLoss.
absl::StatusOr<CheckpointInfo> read_checkpoint_info(std::string_view checkpoint);

}  // namespace creep
