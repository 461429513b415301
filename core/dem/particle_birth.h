// Particles come into being here, in packing and in splits alike: mass, strength, crack from diameter and id.
#pragma once

#include <cstdint>

#include "core/dem/specimen.h"
#include "core/experiment/experiment.h"

namespace creep {

struct Birth {
  std::uint64_t id = 0;
  std::uint64_t parent = 0;
  std::int32_t generation = 0;
  double radius = 0.0;             ///< [m]
  double position[3] = {0, 0, 0};  ///< [m]
  double velocity[3] = {0, 0, 0};  ///< [m/s]
  double spin[3] = {0, 0, 0};      ///< [rad/s]; counts where rotation is free
};

/// Appends a particle: sigma_lim (eq 11) and a0 are drawn by its id, inertial mass by the scaling in force.
void append_particle(Particles& particles, const Experiment& experiment, const Birth& birth);

/// Gives every particle the inertial mass of the scaling in force. The kinetic energy that this changes is
/// booked as removed [J], so that the ledger stays closed. A packing is made with physical inertia whatever
/// the scaling: jobs that differ in it share their specimens. @return whether any mass changed; then the
/// stable step is another too.
bool scale_inertia(Specimen& specimen, const Experiment& experiment);

/// From here on walls rub where the material says so, from no force; else they no longer do.
void let_walls_rub(Particles& particles, const Material& material);

/// m of a sphere [kg].
double sphere_mass(double radius, double density);

}  // namespace creep
