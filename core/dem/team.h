// A fixed team of threads that run one function together: fork, compute, join, millions of times a run.
// (kernel)
//
// The work of a round is cut into as many shares as the team has members, and whoever is free claims the next
// share. On a busy machine, where a thread may be off its processor for milliseconds, the others do its share
// instead of waiting. Who computes a share never changes a result: shares are disjoint ranges and sums over
// them are order-free. Waiting threads spin briefly, then sleep.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <thread>
#include <utility>
#include <vector>

namespace creep {

struct Share {
  std::size_t begin = 0, end = 0;
};

class Team {
 public:
  explicit Team(int threads);
  ~Team();
  Team(const Team&) = delete;
  Team& operator=(const Team&) = delete;

  int size() const { return static_cast<int>(threads_.size()) + 1; }

  /// Calls work(share) once for each share = 0 .. size()-1, on any thread, and returns when all are done.
  template <class Work>
  void run(Work&& work) {
    call(&invoke<std::remove_reference_t<Work>>, &work);
  }

  /// Contiguous part of `count` items that is a share, borders on multiples of `grain`.
  Share share(std::size_t count, int member, std::size_t grain = 1) const;

 private:
  using Function = void (*)(void*, int);
  template <class Work>
  static void invoke(void* work, int share) {
    (*static_cast<Work*>(work))(share);
  }
  void call(Function function, void* context);
  void serve();
  /// Computes shares of a round until none is left.
  void work_on(std::uint32_t round);

  std::vector<std::thread> threads_;
  Function function_ = nullptr;
  void* context_ = nullptr;
  /// Round in the upper half, next share to claim in the lower: a thread that comes late claims nothing of
  /// another round.
  alignas(64) std::atomic<std::uint64_t> ticket_{0};
  alignas(64) std::atomic<std::uint32_t> round_{0};
  alignas(64) std::atomic<int> left_{0};  ///< shares not yet computed
  std::atomic<bool> ending_{false};
};

}  // namespace creep
