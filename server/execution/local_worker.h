// One creep-worker as a child of the daemon.
#pragma once

#include <sys/types.h>

#include <cstdint>
#include <filesystem>
#include <optional>
#include <utility>

#include "absl/status/statusor.h"
#include "core/folder/file_descriptor.h"
#include "server/rules/attempt.h"

namespace creepd {

struct WorkerCommand {
  std::filesystem::path program;
  std::filesystem::path folder;
  std::int64_t attempt = 1;
  int threads = 1;
  double checkpoint_interval = 30.0;  ///< [s]
};

/// A pipe ties the worker to the daemon: when the daemon goes, however it goes, the worker reads the end of
/// it and checkpoints. In a process group of its own, below the daemon in priority.
class LocalWorker {
 public:
  static absl::StatusOr<LocalWorker> start(const WorkerCommand& command);

  /// Readable once the process has ended.
  int descriptor() const { return process_.get(); }
  pid_t id() const { return id_; }

  void send(int signal_number) const;

  /// How it ended; nothing while it runs. Not to be asked again afterwards.
  std::optional<ProcessEnd> poll();

 private:
  LocalWorker(pid_t id, creep::FileDescriptor process, creep::FileDescriptor pipe)
      : id_(id), process_(std::move(process)), pipe_(std::move(pipe)) {}

  pid_t id_;
  creep::FileDescriptor process_;
  creep::FileDescriptor pipe_;
};

}  // namespace creepd
