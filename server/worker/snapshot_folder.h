// snapshots/: the pictures of a job and the collections that a viewer opens as one film.
//
// particles.pvd and contacts.pvd list the files that are there, each with its laboratory time (age plus
// dynamic time since the end of packing). They are written anew whenever a file comes. What a picture is
// called depends on the run alone, so a resumed run writes those it repeats over themselves, byte for byte.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <span>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/output/snapshot.h"

namespace creepd {

class SnapshotFolder {
 public:
  /// Reads what is there and removes what a killed writer left half done. The folder need not exist: the
  /// first picture makes it.
  static absl::StatusOr<SnapshotFolder> open(const std::filesystem::path& folder);

  /// Durable.
  absl::Status write(std::span<const creep::Snapshot> snapshots);

  /// Removes the pictures that were taken after record `sequence`: another course of the run has superseded
  /// them.
  absl::Status drop_after(std::uint64_t sequence);

 private:
  explicit SnapshotFolder(std::filesystem::path folder) : folder_(std::move(folder)) {}

  absl::Status write_collections() const;

  std::filesystem::path folder_;
  std::map<std::string, creep::SnapshotHead> heads_;  // by file name, which is the order of the run
};

}  // namespace creepd
