// How many cycles to ask for at once, so that one advance() takes about a fifth of a second: short enough to
// answer a signal, long enough to cost nothing. Never changes a result.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace creepd {

class Pace {
 public:
  std::int64_t cycle_budget() const { return budget_; }

  /// Learns from what the last call took. A stage that ended early still tells the speed.
  void took(std::int64_t cycles, double wall_seconds) {
    if (cycles <= 0) return;
    const double fitting = static_cast<double>(cycles) * kSeconds / std::max(wall_seconds, 1e-6);
    const double growth_bounded = std::min(fitting, 4.0 * static_cast<double>(budget_));
    budget_ = std::clamp<std::int64_t>(std::llround(growth_bounded), 1, kMostCycles);
  }

 private:
  static constexpr double kSeconds = 0.2;
  static constexpr std::int64_t kMostCycles = 1'000'000;

  std::int64_t budget_ = 16;
};

}  // namespace creepd
