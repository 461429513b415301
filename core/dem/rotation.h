// Free rotation, for scenes that ask for it: spheres turn under the tangential forces of their contacts.
//
// The contact kernel leaves the couple of each contact behind, the particle kernel the forces of walls that
// rub. Spins leap like velocities, and local damping acts on moments as it does on forces.
#pragma once

#include <cstddef>

#include "core/arithmetic/fixed_point.h"
#include "core/dem/specimen.h"

namespace creep {

/// 2/5 m r^2, of the inertial mass [kg m2].
double moment_of_inertia(const Particles& particles, std::size_t i);

/// Spins of the particles [begin, end) after one kick [s]; couples are those of the present contacts. Returns
/// the work of local damping [J].
FixedSum turn(Specimen& specimen, double local_damping, double kick, std::size_t begin, std::size_t end);

}  // namespace creep
