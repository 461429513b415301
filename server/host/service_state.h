// What the service manager (systemd, Type=notify) is told about this daemon; without one nothing is sent.
#pragma once

#include <chrono>
#include <string>

namespace creepd {

class ServiceState {
 public:
  /// Finds out from the environment how often a sign of life is wanted.
  ServiceState();

  void recovering() const;
  /// Everything recovered, and the doors open.
  void ready() const;
  void stopping() const;

  /// A turn of the supervisor has ended: the sign of life, and what `systemctl status` shows. Only from the
  /// supervisor's thread, at least every second.
  void turned(int running, int slots);

 private:
  using Clock = std::chrono::steady_clock;

  std::chrono::microseconds alive_interval_{0};  ///< 0 = not wanted
  Clock::time_point told_alive_{};
  int told_running_ = -1;
};

}  // namespace creepd
