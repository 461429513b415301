// The checkpoints of one job: checkpoints/ck.1, ck.2, ... of which the three newest verified ones are kept.
//
// A new generation counts only after it was written, made durable, read again and verified; only then the
// oldest is dropped. So at every moment, and after a power cut, at least one good one is there. A file that
// was found damaged is renamed bad.N: it is kept for a look, and neither counts nor is tried again.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/state/checkpoint.h"

namespace creep {

class CheckpointStore {
 public:
  /// Verifies bytes without loading them; read_checkpoint_info in every use outside tests. Its
  /// FailedPrecondition (the newest is of a newer program) is passed on: such a file is neither set aside nor
  /// deleted.
  using Verify = absl::StatusOr<CheckpointInfo> (*)(std::string_view);

  static constexpr std::size_t kGenerations = 3;

  struct Loaded {
    std::uint64_t generation = 0;
    std::string bytes;
    CheckpointInfo info;
  };
  struct Rejected {
    std::uint64_t generation = 0;
    std::string reason;
  };
  struct Newest {
    std::optional<Loaded> loaded;    ///< nothing if no file is good
    std::vector<Rejected> rejected;  ///< newer ones that are not, newest first
  };

  /// Makes the directory if need be and removes what a killed writer left half done. Errors: of `verify`, or
  /// of the file system.
  static absl::StatusOr<CheckpointStore> open(const std::filesystem::path& directory, Verify verify);

  /// The newest good generation that `usable` accepts; damaged newer ones are set aside. Errors: of `verify`,
  /// or of reading, when the storage fails rather than the file being damaged.
  absl::StatusOr<Newest> load_newest(const std::function<absl::Status(const CheckpointInfo&)>& usable);

  /// Stores a checkpoint for good as keep.NAME; the same name again replaces it.
  absl::Status keep(std::string_view name, std::string_view bytes) const;

  /// Adds a generation and returns its number. On an error the older ones stand as they were.
  absl::StatusOr<std::uint64_t> add(std::string_view bytes);

  const std::vector<std::uint64_t>& generations() const { return generations_; }  ///< oldest first

 private:
  CheckpointStore(std::filesystem::path directory, Verify verify)
      : directory_(std::move(directory)), verify_(verify) {}

  std::filesystem::path file_of(std::uint64_t generation) const;

  std::filesystem::path directory_;
  Verify verify_;
  std::vector<std::uint64_t> generations_;
  std::uint64_t last_number_ = 0;  ///< highest ever given, bad ones included
};

/// The numbers N of the files PREFIX.N in a directory, ascending; other names are passed over.
absl::StatusOr<std::vector<std::uint64_t>> numbered_files(const std::filesystem::path& directory,
                                                          std::string_view prefix);

}  // namespace creep
