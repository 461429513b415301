// Attempts as child processes on this machine.
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/folder/file_descriptor.h"
#include "server/execution/executor.h"
#include "server/execution/local_worker.h"

namespace creepd {

struct LocalExecutorOptions {
  std::filesystem::path worker;  ///< program
  int slots = 1;
  std::uint64_t memory_limit = 0;  ///< for the sum of the estimates of running jobs [bytes]
};

class LocalExecutor final : public Executor {
 public:
  explicit LocalExecutor(LocalExecutorOptions options);

  std::string engine() const override { return "local"; }
  bool has_room(std::uint64_t memory) const override;
  absl::Status start(const AttemptOrder& order) override;
  void stop(const AttemptKey& key, StopMode mode) override;
  std::vector<AttemptNews> news() override;
  void forget(const AttemptKey& key) override;
  /// Workers of a daemon that is gone have read the end of their pipe and are ending; nobody here can see it,
  /// but the supervisor sees their leases.
  void adopt(const std::vector<AttemptKey>& keys) override;
  bool survives_daemon() const override { return false; }
  int descriptor() const override { return news_.get(); }

 private:
  using Clock = std::chrono::steady_clock;

  struct Child {
    std::optional<LocalWorker> worker;  ///< nothing once it has ended
    std::string id;
    std::uint64_t memory = 0;
    std::uint64_t kills_for_memory = 0;  ///< of the machine, when it started
    bool killed = false;                 ///< from here
    std::optional<ProcessEnd> end;
    Cause cause = Cause::kNone;
  };

  LocalExecutorOptions options_;
  creep::FileDescriptor news_;  ///< epoll over the children
  std::map<AttemptKey, Child> children_;
  std::map<AttemptKey, Clock::time_point> adopted_;
};

}  // namespace creepd
