// The folder of the queue and of all jobs: whose it is, and that one daemon at a time uses it.
#pragma once

#include <filesystem>
#include <utility>

#include "absl/status/statusor.h"
#include "core/folder/file_descriptor.h"

namespace creepd {

class StateFolder {
 public:
  /// Makes the folder if need be, and keeps other daemons out as long as the object lives. It must belong to
  /// the user of this process and be written by nobody else; the way to it may also be root's. Errors:
  /// FailedPrecondition (it is not so: whose it is, and what cures it), AlreadyExists (another daemon uses
  /// it), or of the file system.
  static absl::StatusOr<StateFolder> take(const std::filesystem::path& path);

 private:
  StateFolder(creep::FileDescriptor folder, creep::FileDescriptor lock)
      : folder_(std::move(folder)), lock_(std::move(lock)) {}

  creep::FileDescriptor folder_;  // locked itself: a lock file can be deleted
  creep::FileDescriptor lock_;
};

}  // namespace creepd
