#include "core/arithmetic/random.h"

#include <Random123/philox.h>

#include "core/arithmetic/elementary.h"

namespace creep {
namespace {

std::uint32_t low_word(std::uint64_t x) { return static_cast<std::uint32_t>(x & 0xffffffffU); }
std::uint32_t high_word(std::uint64_t x) { return static_cast<std::uint32_t>(x >> 32); }

}  // namespace

double uniform(std::uint64_t seed, std::uint64_t id, RandomEvent event, std::uint32_t draw) {
  const r123::Philox4x32::ctr_type counter = {
      {low_word(id), high_word(id), static_cast<std::uint32_t>(event), draw}};
  const r123::Philox4x32::key_type key = {{low_word(seed), high_word(seed)}};
  const r123::Philox4x32::ctr_type words = r123::Philox4x32{}(counter, key);
  const std::uint64_t bits = (std::uint64_t{words[1]} << 32) | words[0];
  // (k + 1/2) 2^-52 with 52 random bits k: exact in double, and symmetric about 1/2.
  return (static_cast<double>(bits >> 12) + 0.5) * 0x1p-52;
}

double normal(std::uint64_t seed, std::uint64_t id, RandomEvent event, std::uint32_t draw) {
  return elementary::inverse_normal_cdf(uniform(seed, id, event, draw));
}

}  // namespace creep
