// creep-worker as a child of `run`: started from the folder of this program, in its process group.
#pragma once

#include <sys/types.h>

#include <chrono>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"

namespace creepctl {

/// How the worker ended.
struct WorkerEnd {
  int exit_code = 0;
  int signal = 0;  ///< that killed it; 0 if none did
};

class WorkerProcess {
 public:
  /// Starts the worker with these arguments; its stderr is added to `log`. From now on SIGINT, SIGTERM and
  /// SIGHUP reach this process only through wait(), which passes them on. If this process dies, the worker
  /// notices the end of a pipe, checkpoints and ends. Error: Unavailable (no creep-worker beside this
  /// program, or no process).
  static absl::StatusOr<WorkerProcess> start(std::vector<std::string> arguments,
                                             const std::filesystem::path& log);

  WorkerProcess(WorkerProcess&& other) noexcept;
  WorkerProcess& operator=(WorkerProcess&&) = delete;
  ~WorkerProcess();

  /// Waits at most `patience`; the end, once there is one.
  std::optional<WorkerEnd> wait(std::chrono::milliseconds patience);

  /// Has the worker checkpoint and end, as a signal would.
  void stop();

  bool stopping() const { return stopping_; }  ///< stop() was called, or a signal passed on

 private:
  WorkerProcess() = default;

  pid_t process_ = -1;
  int parent_pipe_ = -1;  ///< writing end, held open and never written to
  int signals_ = -1;
  bool stopping_ = false;
};

}  // namespace creepctl
