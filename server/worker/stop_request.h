// "Checkpoint and end": SIGTERM, SIGINT, SIGHUP unless it is ignored (nohup), or the end of the pipe from the
// process that started this one.
#pragma once

#include <optional>
#include <string>

#include "absl/status/statusor.h"
#include "core/folder/file_descriptor.h"

namespace creepd {

class StopRequest {
 public:
  /// Blocks the signals from now on, also in threads made later, so that they are seen only here. Make it
  /// before any thread. `parent_pipe` is the reading end, if there is one. Error: of the system, or a bad
  /// descriptor.
  static absl::StatusOr<StopRequest> listen(std::optional<int> parent_pipe);

  /// Who asked, once someone has: "SIGTERM", "SIGINT", "SIGHUP", "end of the parent's pipe". Never waits.
  std::optional<std::string> poll();

 private:
  StopRequest(creep::FileDescriptor signals, creep::FileDescriptor parent)
      : signals_(std::move(signals)), parent_(std::move(parent)) {}

  creep::FileDescriptor signals_;
  creep::FileDescriptor parent_;  ///< not open without a parent
  std::string request_;           ///< empty until someone has asked
};

}  // namespace creepd
