#include "server/host/service_state.h"

#include <systemd/sd-daemon.h>

#include <cstdint>

#include "absl/strings/str_cat.h"

namespace creepd {
namespace {

constexpr int kKeepEnvironment = 0;

// That nobody listens, or no longer, is no concern of the jobs.
void tell(const std::string& state) { ::sd_notify(kKeepEnvironment, state.c_str()); }

}  // namespace

ServiceState::ServiceState() {
  std::uint64_t limit = 0;
  // Half of it, as systemd asks: one late turn is not a death.
  if (::sd_watchdog_enabled(kKeepEnvironment, &limit) > 0)
    alive_interval_ = std::chrono::microseconds(limit / 2);
}

void ServiceState::recovering() const { tell("STATUS=recovering the jobs of the last creepd"); }

void ServiceState::ready() const { tell("READY=1\nWATCHDOG=1"); }

void ServiceState::stopping() const { tell("STOPPING=1\nSTATUS=workers write a checkpoint"); }

void ServiceState::turned(int running, int slots) {
  std::string news;
  const auto now = Clock::now();
  if (alive_interval_.count() > 0 && now - told_alive_ >= alive_interval_) {
    told_alive_ = now;
    news = "WATCHDOG=1\n";
  }
  if (running != told_running_) {
    told_running_ = running;
    absl::StrAppend(&news, "STATUS=", running, " of ", slots, " slots in use\n");
  }
  if (!news.empty()) tell(news);
}

}  // namespace creepd
