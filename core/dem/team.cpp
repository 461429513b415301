#include "core/dem/team.h"

#if defined(__x86_64__)
#include <immintrin.h>
#endif

namespace creep {
namespace {

/// About 20 us on a 3 GHz processor: longer than a phase of a small specimen, shorter than a scheduler slice.
constexpr int kSpins = 2000;

void pause_once() {
#if defined(__x86_64__)
  _mm_pause();
#endif
}

}  // namespace

Team::Team(int threads) {
  for (int member = 1; member < threads; ++member) {
    threads_.emplace_back([this, member] { serve(member); });
  }
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
  running_.store(static_cast<int>(threads_.size()), std::memory_order_relaxed);
  round_.fetch_add(1, std::memory_order_release);
  round_.notify_all();
  function(context, 0);
  int spins = 0;
  for (int left = running_.load(std::memory_order_acquire); left != 0;
       left = running_.load(std::memory_order_acquire)) {
    if (++spins < kSpins) {
      pause_once();
    } else {
      running_.wait(left, std::memory_order_acquire);
    }
  }
}

void Team::serve(int member) {
  unsigned seen = 0;
  while (true) {
    int spins = 0;
    unsigned round = round_.load(std::memory_order_acquire);
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
    function_(context_, member);
    if (running_.fetch_sub(1, std::memory_order_acq_rel) == 1) running_.notify_one();
  }
}

}  // namespace creep
