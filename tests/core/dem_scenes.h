// Small specimens that tests of the discrete elements start from.
#pragma once

#include <cstdint>
#include <initializer_list>
#include <string>
#include <vector>

#include "core/dem/dynamics.h"
#include "core/dem/packing.h"
#include "core/dem/specimen.h"
#include "core/experiment/experiment.h"

namespace creep::testing {

/// Grains of the default sand that break at a few MPa and whose larger fragments can break again. The void
/// ratio is so loose that packing ends as soon as the isotropic stress is reached.
Experiment weak_sand(std::int64_t particles);

/// The same grains, none of which can break.
Experiment unbreakable_sand(std::int64_t particles);

/// The widest kernels of this processor.
const Kernels& widest_kernels();

/// Packs until done; a fault fails the test.
Specimen packed(const Experiment& experiment, Dynamics& dynamics, PackingState* state = nullptr);

/// Grains exactly as given, at rest, in a cube [0, side]; assessed by nobody yet.
struct Ball {
  double x = 0.0, y = 0.0, z = 0.0, radius = 0.0;  // [m]
  double vx = 0.0, vy = 0.0, vz = 0.0;             // [m/s]
};
Specimen balls(const Experiment& experiment, double side, const std::vector<Ball>& given);

/// All three axes servo-controlled.
WallControl isotropic(double stress, double closing_velocity);
/// Top and bottom alone.
WallControl oedometric(double stress, double closing_velocity);

/// Runs cycles and splits what fails; returns how many broke.
std::int64_t run_cycles(Specimen& specimen, const Experiment& experiment, Dynamics& dynamics,
                        const WallControl& control, std::int64_t cycles);

}  // namespace creep::testing
