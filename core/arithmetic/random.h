// Counter-based random numbers (Random123 Philox4x32-10, Salmon et al. 2011).
//
// A number is a pure function of (seed, particle id, event, draw): no generator state to save, and no
// dependence on the order in which particles are visited. Ids are never reused, so no number is ever drawn
// twice.
#pragma once

#include <cstdint>

namespace creep {

/// What a number is drawn for. The values are part of every stored result: never renumber.
enum class RandomEvent : std::uint32_t {
  kPosition = 0,
  kStrength = 1,
  kCrack = 2,
  kAzimuth = 3,
  kShuffle = 4
};

/// Uniform in the open interval (0, 1): an odd multiple of 2^-53, never 0 or 1. `draw` numbers the draws of
/// one event.
double uniform(std::uint64_t seed, std::uint64_t id, RandomEvent event, std::uint32_t draw = 0);

/// Standard normal: the quantile of uniform() with the same arguments; |value| < 8.3.
double normal(std::uint64_t seed, std::uint64_t id, RandomEvent event, std::uint32_t draw = 0);

}  // namespace creep
