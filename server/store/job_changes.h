// Who is told of changes of jobs: given to the store when it is opened, listened to by whoever serves
// watchers later. Safe from several threads.
#pragma once

#include <functional>
#include <mutex>
#include <string>
#include <utility>

namespace creepd {

class JobChanges {
 public:
  void tell(const std::string& job) {
    const std::lock_guard lock(mutex_);
    if (listener_) listener_(job);
  }

  /// Nobody with nullptr; then the listener before is not called any more when this returns.
  void listen(std::function<void(const std::string&)> listener) {
    const std::lock_guard lock(mutex_);
    listener_ = std::move(listener);
  }

 private:
  std::mutex mutex_;
  std::function<void(const std::string&)> listener_;
};

}  // namespace creepd
