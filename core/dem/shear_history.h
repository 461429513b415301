// The memory of contacts, by pair instead of by list: for checkpoints, digests and renumbering.
#pragma once

#include <vector>

#include "core/dem/specimen.h"

namespace creep {

/// Tangential force of one pair on its first particle [N]; first < second are indices.
struct PairShear {
  std::int32_t first = 0, second = 0;
  double x = 0.0, y = 0.0, z = 0.0;
};

/// Pairs whose shear force is not zero, in ascending (first, second).
std::vector<PairShear> shear_history(const Contacts& contacts);

/// A list, not yet valid, from which the next search takes the shear forces. @param history  ascending,
/// unique.
Contacts contacts_from_history(std::size_t particles, const std::vector<PairShear>& history);

}  // namespace creep
