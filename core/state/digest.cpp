#include <array>

#include "core/dem/shear_history.h"
#include "core/state/archive.h"
#include "core/state/layout.h"
#include "core/state/state.h"

namespace creep {

std::string digest_of(const RunState& state) {
  Digester digest;
  visit_particles(digest, state.specimen.particles);
  if (!state.specimen.particles.spin.empty()) visit_spin(digest, state.specimen.particles.spin);
  if (!state.specimen.particles.wall_shear.empty()) {
    visit_wall_shear(digest, state.specimen.particles.wall_shear);
  }
  const std::vector<PairShear> history = shear_history(state.specimen.contacts);
  digest(static_cast<std::uint64_t>(history.size()));
  for (const PairShear& pair : history) {
    digest(state.specimen.particles.id[static_cast<std::size_t>(pair.first)]);
    digest(state.specimen.particles.id[static_cast<std::size_t>(pair.second)]);
    digest(pair.x);
    digest(pair.y);
    digest(pair.z);
  }
  visit_surroundings(digest, state.specimen);
  if (state.specimen.walls.carried != std::array<double, 3>{}) {
    visit_carried(digest, state.specimen.walls.carried);
  }
  visit_fines(digest, state.specimen.fines);
  return digest.hex();
}

}  // namespace creep
