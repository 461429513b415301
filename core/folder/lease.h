// The exclusive right to compute in a job directory: a kernel lock, which ends with the process that holds
// it.
//
// The file also carries the number of the attempt, so that a late starter with an older number steps back.
// Nobody removes the file. flock(2) works between processes of one machine and on NFS since Linux 2.6.12.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>

#include "absl/status/statusor.h"
#include "core/folder/file_descriptor.h"

namespace creep {

class Lease {
 public:
  /// Takes the lease and makes the attempt's number durable: the wanted one or, without a wish, one more than
  /// the last. Errors: Unavailable (another worker holds it; the message names it), FailedPrecondition (a
  /// newer attempt was made before), or of the file system.
  static absl::StatusOr<Lease> take(const std::filesystem::path& path,
                                    std::optional<std::int64_t> wanted_attempt);

  std::int64_t attempt() const { return attempt_; }  ///< from 1

 private:
  Lease(FileDescriptor file, std::int64_t attempt) : file_(std::move(file)), attempt_(attempt) {}

  FileDescriptor file_;
  std::int64_t attempt_;
};

}  // namespace creep
