#include "core/dem/team.h"

#if defined(__x86_64__)
#include <immintrin.h>
#endif

namespace creep {
namespace {

/// A few tenths of a millisecond: longer than a phase of any specimen that fits a cache, so that partners who
/// are only a little late find each other awake; sleeping and waking costs as much as a phase.
constexpr int kSpins = 20000;

void pause_once() {
#if defined(__x86_64__)
  _mm_pause();
#endif
}

}  // namespace

Team::Team(int threads) {
  for (int member = 1; member < threads; ++member) threads_.emplace_back([this] { serve(); });
}

Team::~Team() {
  ending_.store(true);
  round_.fetch_add(1, std::memory_order_release);
  round_.notify_all();
  for (std::thread& thread : threads_) thread.join();
}

Share Team::share(std::size_t count, int member, std::size_t grain) const {
  const std::size_t grains = (count + grain - 1) / grain;
  const auto members = static_cast<std::size_t>(size());
  const auto m = static_cast<std::size_t>(member);
  const std::size_t begin = grains * m / members * grain;
  const std::size_t end = grains * (m + 1) / members * grain;
  return {begin < count ? begin : count, end < count ? end : count};
}

void Team::call(Function function, void* context) {
  if (threads_.empty()) {
    function(context, 0);
    return;
  }
  function_ = function;
  context_ = context;
  left_.store(size(), std::memory_order_relaxed);
  const std::uint32_t round = round_.load(std::memory_order_relaxed) + 1;
  ticket_.store(std::uint64_t{round} << 32, std::memory_order_release);
  round_.store(round, std::memory_order_release);
  round_.notify_all();
  work_on(round);
  int spins = 0;
  for (int left = left_.load(std::memory_order_acquire); left != 0;
       left = left_.load(std::memory_order_acquire)) {
    if (++spins < kSpins) {
      pause_once();
    } else {
      left_.wait(left, std::memory_order_acquire);
    }
  }
}

void Team::work_on(std::uint32_t round) {
  std::uint64_t ticket = ticket_.load(std::memory_order_acquire);
  while (ticket >> 32 == round && static_cast<int>(ticket & 0xffffffffu) < size()) {
    if (!ticket_.compare_exchange_weak(ticket, ticket + 1, std::memory_order_acq_rel)) continue;
    function_(context_, static_cast<int>(ticket & 0xffffffffu));
    if (left_.fetch_sub(1, std::memory_order_acq_rel) == 1) left_.notify_one();
    ticket = ticket_.load(std::memory_order_acquire);
  }
}

void Team::serve() {
  std::uint32_t seen = 0;
  while (true) {
    int spins = 0;
    std::uint32_t round = round_.load(std::memory_order_acquire);
    while (round == seen) {
      if (++spins < kSpins) {
        pause_once();
      } else {
        round_.wait(seen, std::memory_order_acquire);
      }
      round = round_.load(std::memory_order_acquire);
    }
    seen = round;
    if (ending_.load()) return;
    work_on(round);
  }
}

}  // namespace creep
