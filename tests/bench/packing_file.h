// A specimen from a file of spheres: no history, forces follow from overlaps.
#pragma once

#include <string>

#include "absl/status/statusor.h"
#include "core/dem/specimen.h"
#include "core/experiment/experiment.h"

namespace creep::bench {

/// Lines "x y z radius" [m]; lines that start with # are comments, the first of which holds
/// "box x0 y0 z0 x1 y1 z1" [m]. Particles are sorted in space, as those of a job are; velocities are seeded,
/// up to `largest_velocity` [m/s] a component. Error: InvalidArgument with the line.
absl::StatusOr<Specimen> read_packing(const std::string& path, const Experiment& experiment,
                                      double largest_velocity);

}  // namespace creep::bench
