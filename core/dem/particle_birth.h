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

/// m of a sphere [kg].
double sphere_mass(double radius, double density);

}  // namespace creep
