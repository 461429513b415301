// A fixed team of threads that run one function together: fork, compute, join, millions of times a run.
//
// Waiting threads spin briefly, then sleep. Which thread does which share never changes a result: shares are
// disjoint ranges and sums over them are order-free.
#pragma once

#include <atomic>
#include <cstddef>
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

  /// Calls work(member) for member = 0 .. size()-1, one thread each, and returns when all are done.
  template <class Work>
  void run(Work&& work) {
    call(&invoke<std::remove_reference_t<Work>>, &work);
  }

  /// Contiguous share of `count` items for a member, borders on multiples of `grain`.
  Share share(std::size_t count, int member, std::size_t grain = 1) const;

 private:
  using Function = void (*)(void*, int);
  template <class Work>
  static void invoke(void* work, int member) {
    (*static_cast<Work*>(work))(member);
  }
  void call(Function function, void* context);
  void serve(int member);

  std::vector<std::thread> threads_;
  Function function_ = nullptr;
  void* context_ = nullptr;
  alignas(64) std::atomic<unsigned> round_{0};
  alignas(64) std::atomic<int> running_{0};
  std::atomic<bool> ending_{false};
};

}  // namespace creep
