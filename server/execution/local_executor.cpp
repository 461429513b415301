#include "server/execution/local_executor.h"

#include <signal.h>
#include <sys/epoll.h>

#include <fstream>
#include <utility>

#include "absl/strings/str_cat.h"

namespace creepd {
namespace {

/// Former workers are about to end, and their jobs, being older, go on first: so long their slots are theirs.
constexpr std::chrono::seconds kSlotOfFormerWorker{10};

/// Processes that the kernel has killed for memory since the machine started.
std::uint64_t kills_for_memory() {
  std::ifstream statistics("/proc/vmstat");
  std::string name;
  std::uint64_t value = 0;
  while (statistics >> name >> value) {
    if (name == "oom_kill") return value;
  }
  return 0;
}

}  // namespace

LocalExecutor::LocalExecutor(LocalExecutorOptions options)
    : options_(std::move(options)), news_(::epoll_create1(EPOLL_CLOEXEC)) {}

bool LocalExecutor::has_room(std::uint64_t memory) const {
  std::size_t taken = children_.size();
  for (const auto& [key, since] : adopted_) taken += Clock::now() - since < kSlotOfFormerWorker ? 1 : 0;
  if (taken >= static_cast<std::size_t>(options_.slots)) return false;
  // The only one runs however much it needs: what cannot run at all was refused when it was submitted.
  for (const auto& [key, child] : children_) memory += child.memory;
  return memory <= options_.memory_limit || taken == 0;
}

absl::Status LocalExecutor::start(const AttemptOrder& order) {
  Child child;
  child.memory = order.memory;
  child.kills_for_memory = kills_for_memory();
  auto worker = LocalWorker::start(
      {options_.worker, order.folder, order.key.number, order.threads, order.checkpoint_interval});
  // Unavailable would mean that it may run all the same.
  if (!worker.ok()) return absl::AbortedError(worker.status().message());
  child.id = absl::StrCat(worker->id());
  epoll_event event{};
  event.events = EPOLLIN;
  ::epoll_ctl(news_.get(), EPOLL_CTL_ADD, worker->descriptor(), &event);
  child.worker = *std::move(worker);
  children_.emplace(order.key, std::move(child));
  return absl::OkStatus();
}

void LocalExecutor::stop(const AttemptKey& key, StopMode mode) {
  const auto found = children_.find(key);
  if (found == children_.end() || !found->second.worker) return;
  Child& child = found->second;
  child.killed = child.killed || mode == StopMode::kNow;
  child.worker->send(mode == StopMode::kNow ? SIGKILL : SIGTERM);
}

std::vector<AttemptNews> LocalExecutor::news() {
  std::vector<AttemptNews> all;
  for (auto& [key, child] : children_) {
    if (child.worker) child.end = child.worker->poll();
    if (child.worker && child.end) {
      child.worker.reset();  // its descriptor leaves the epoll by being closed
      if (child.end->signal == SIGKILL && !child.killed && kills_for_memory() > child.kills_for_memory)
        child.cause = Cause::kOutOfMemory;
    }
    AttemptNews news;
    news.key = key;
    news.phase = child.end ? Phase::kEnded : Phase::kRunning;
    news.cause = child.cause;
    news.process = child.end;
    news.engine_id = child.id;
    news.place = absl::StrCat("process ", child.id);
    all.push_back(std::move(news));
  }
  for (const auto& [key, since] : adopted_) {
    AttemptNews news;
    news.key = key;
    news.phase = Phase::kEnded;
    all.push_back(std::move(news));
  }
  return all;
}

void LocalExecutor::forget(const AttemptKey& key) {
  children_.erase(key);
  adopted_.erase(key);
}

void LocalExecutor::adopt(const std::vector<AttemptKey>& keys) {
  for (const AttemptKey& key : keys) adopted_.emplace(key, Clock::now());
}

}  // namespace creepd
