// The specimen as a picture: VTK XML PolyData files, as ParaView opens them.
//
// A snapshot is two files: the particles as points, and the contacts between them as lines from centre to
// centre (contacts with walls are not drawn). Numbers are inline base64 binary, so they are exact, and depend
// on the state alone: not on threads, the list, or how often the run was resumed.
//
//   particles  id, parent, generation, radius, diameter_mm, velocity, mobilised_stress_Pa, limit_stress_Pa,
//              stress_ratio, crack_ratio (a/R; failure at 1)
//   contacts   normal_force_N, shear_force_N, sliding (1 at the Coulomb limit), overlap_m
//
// Contacts of the second file join points of the first: both have the particles in ascending id.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "core/dem/contact_model.h"
#include "core/state/state.h"

namespace creep {

/// When a snapshot was taken.
struct SnapshotHead {
  double age = 0.0;                 ///< [s]
  double dynamic_time = 0.0;        ///< [s]
  double creep_time = 0.0;          ///< [s]; 0 outside a hold
  std::uint64_t next_sequence = 0;  ///< of the first record made after it
};

/// One file for a viewer.
struct Snapshot {
  std::string name;  ///< of the file; the same state has the same name in every attempt
  SnapshotHead head;
  std::string bytes;
};

/// Both files of the specimen as it stands; "particles_02_creep_0004.vtp" is that of the second stage of the
/// program after the fourth ageing jump, stage 00 is the packing. Needs a valid list.
std::vector<Snapshot> snapshots(const RunState& state, const Experiment& experiment,
                                const ContactModel& model);

/// When a file was taken, read from its first lines. Error: DataLoss if it is no file of ours.
absl::StatusOr<SnapshotHead> read_snapshot_head(std::string_view bytes);

}  // namespace creep
