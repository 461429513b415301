#include "server/worker/profile.h"

#include <chrono>
#include <cstdio>
#include <string>

#include "core/folder/durable_file.h"

namespace creepd {
namespace {

constexpr std::chrono::milliseconds kInterval(1);

}  // namespace

Profile::Profile() : thread_([this] { look(); }) {}

Profile::~Profile() { stop(); }

void Profile::look() {
  // Each look stands for the time since the one before: a thread that was late counts what it missed.
  using Clock = std::chrono::steady_clock;
  auto before = Clock::now();
  std::unique_lock lock(mutex_);
  while (!ending_) {
    wake_.wait_for(lock, kInterval);
    const auto now = Clock::now();
    seen_[static_cast<std::size_t>(mark_.load(std::memory_order_relaxed))] +=
        std::chrono::nanoseconds(now - before).count();
    before = now;
  }
}

void Profile::stop() {
  {
    const std::lock_guard lock(mutex_);
    ending_ = true;
  }
  wake_.notify_one();
  if (thread_.joinable()) thread_.join();
}

absl::Status Profile::write(const std::filesystem::path& path) {
  stop();
  std::int64_t all = 0;
  for (const std::int64_t nanoseconds : seen_) all += nanoseconds;
  std::string text = "activity,seconds,share\n";
  for (std::size_t k = 0; k < seen_.size(); ++k) {
    char line[96];
    std::snprintf(line, sizeof line, "%s,%.3f,%.4f\n", creep::kActivityNames[k],
                  1e-9 * static_cast<double>(seen_[k]),
                  all > 0 ? static_cast<double>(seen_[k]) / static_cast<double>(all) : 0.0);
    text += line;
  }
  return creep::replace_file(path, text);
}

}  // namespace creepd
