// What a run is doing, marked for whoever samples it from another thread: core itself reads no clock.
// (kernel)
#pragma once

#include <array>
#include <atomic>
#include <cstdint>

namespace creep {

enum class Activity : std::uint8_t {
  kOther,      ///< walls, clocks, the turn of a cycle
  kSearch,     ///< neighbour search
  kContacts,   ///< contact kernel
  kParticles,  ///< particle kernel
  kChecks,     ///< immediate failures, cracks
  kBreaking,   ///< splitting
  kAgeing,     ///< ageing jumps
  kMeasures,   ///< samples, gradings, stage rows
  kOutput,     ///< files, checkpoints: marked by the caller of the run
};
inline constexpr std::array<const char*, 9> kActivityNames = {
    "other", "search", "contacts", "particles", "checks", "breaking", "ageing", "measures", "output"};

using ActivityMark = std::atomic<Activity>;

/// Marks an activity until the end of its scope. `mark` may be nullptr: nobody samples.
class Doing {
 public:
  Doing(ActivityMark* mark, Activity activity) : mark_(mark) {
    if (mark_ == nullptr) return;
    before_ = mark_->load(std::memory_order_relaxed);
    mark_->store(activity, std::memory_order_relaxed);
  }
  Doing(const Doing&) = delete;
  Doing& operator=(const Doing&) = delete;
  ~Doing() {
    if (mark_ != nullptr) mark_->store(before_, std::memory_order_relaxed);
  }

 private:
  ActivityMark* mark_;
  Activity before_ = Activity::kOther;
};

}  // namespace creep
