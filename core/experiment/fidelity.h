// The named settings of [numerics], and what was measured of each: error and cost.
//
// Source of every number: tests/studies/accuracy_speed, whose README says on which specimens.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "core/experiment/experiment.h"

namespace creep {

/// What a fidelity was measured to miss and to cost.
struct FidelityMeasure {
  /// Far end of the 95 % interval of the paired difference from the reference, over the mean of the
  /// reference: the largest of the void ratio before creep and the creep strain at 600 s, 1e4 s and 2 d [-].
  /// Of the reference itself: what stands in for it on the larger specimens may differ by as much.
  double error = 0.0;
  double speed = 1.0;  ///< particle-steps of "paper" over its own [-]
};

/// "reference", "paper", "balanced", "fast".
std::span<const std::string_view> fidelity_names();

/// The settings of fidelity_names()[index]; the name is theirs.
Numerics fidelity_numerics(std::size_t index);

/// Of fidelity_names()[index], on specimens of kMeasuredParticles.
FidelityMeasure fidelity_measure(std::size_t index);
inline constexpr int kMeasuredParticles = 3000;

/// The cheapest whose measured error is at most `error` [-]; none if only less was measured.
std::optional<std::size_t> cheapest_fidelity(double error);

/// The one with the least measured error.
std::size_t most_accurate_fidelity();

/// The index of a name; none if it is none of them.
std::optional<std::size_t> fidelity_index(std::string_view name);

/// n_age: the job's, or round(fraction x initial count), at least 1.
std::int64_t breakages_per_ageing(const Numerics& numerics, std::int64_t initial_count);

}  // namespace creep
