#include "core/experiment/fidelity.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/arithmetic/check.h"

namespace creep {
namespace {

constexpr std::array<std::string_view, 4> kNames = {"reference", "paper", "balanced", "fast"};

// In the order of kNames. The reference was not run at this size: its error is that of what stands in for it
// at 800 particles, its speed follows from the stages that this counted, at the length of the paper's.
constexpr std::array<FidelityMeasure, kNames.size()> kMeasures = {{
    {.error = 0.014, .speed = 0.14},
    {.error = 0.22, .speed = 1.0},
    {.error = 0.045, .speed = 30.6},
    {.error = 0.17, .speed = 139.0},
}};

/// Every stage of full length, half the step, one failure a jump, closer to equilibrium.
void be_reference(Numerics& numerics) {
  numerics.time_step_safety = 0.35;
  numerics.breakages_per_ageing = 1;
  numerics.settle_tolerance = 0.002;
  numerics.unbalanced_tolerance = 1e-5;
}

/// All inertia scaled; a dynamic stage ends when the times of the next failures stand still; loading as fast
/// as the inertial number allows.
void be_fast(Numerics& numerics) {
  numerics.minimum_cycles = 300;
  numerics.drift_tolerance = 0.1;
  numerics.inertia_scaling = InertiaScaling::kAll;
  numerics.loading_velocity = 1.0;
  numerics.inertial_number_limit = 0.003;
}

/// The forces are found anew after every failure in 3 000 particles, not only after 0.26 % of them have
/// failed.
void be_balanced(Numerics& numerics) {
  be_fast(numerics);
  numerics.breakage_fraction = 0.00033;
}

}  // namespace

std::span<const std::string_view> fidelity_names() { return kNames; }

Numerics fidelity_numerics(std::size_t index) {
  CREEP_CHECK(index < kNames.size(), "a fidelity that is not there");
  Numerics numerics;  // the defaults of the struct are those of the paper
  numerics.fidelity = std::string(kNames[index]);
  if (kNames[index] == "reference") be_reference(numerics);
  if (kNames[index] == "balanced") be_balanced(numerics);
  if (kNames[index] == "fast") be_fast(numerics);
  return numerics;
}

FidelityMeasure fidelity_measure(std::size_t index) {
  CREEP_CHECK(index < kMeasures.size(), "a fidelity that is not there");
  return kMeasures[index];
}

std::optional<std::size_t> cheapest_fidelity(double error) {
  std::optional<std::size_t> best;
  for (std::size_t i = 0; i < kMeasures.size(); ++i) {
    if (kMeasures[i].error <= error && (!best || kMeasures[i].speed > kMeasures[*best].speed)) best = i;
  }
  return best;
}

std::size_t most_accurate_fidelity() {
  const auto less = [](const FidelityMeasure& a, const FidelityMeasure& b) { return a.error < b.error; };
  return static_cast<std::size_t>(std::min_element(kMeasures.begin(), kMeasures.end(), less) -
                                  kMeasures.begin());
}

std::optional<std::size_t> fidelity_index(std::string_view name) {
  const auto found = std::find(kNames.begin(), kNames.end(), name);
  if (found == kNames.end()) return std::nullopt;
  return static_cast<std::size_t>(found - kNames.begin());
}

std::int64_t breakages_per_ageing(const Numerics& numerics, std::int64_t initial_count) {
  if (numerics.breakages_per_ageing) return *numerics.breakages_per_ageing;
  return std::max<std::int64_t>(
      1, std::llround(numerics.breakage_fraction * static_cast<double>(initial_count)));
}

}  // namespace creep
