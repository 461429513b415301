// How many particles a job will hold: for sizing it, never part of a result.
#pragma once

#include "core/experiment/experiment.h"

namespace creep {

/// At the start: as given, or as fit into the cube at its void ratio [-]. 0 if the specimen is another job's.
double initial_particle_count(const SpecimenSpec& specimen);

/// A safe guess of the most there will be, fragments included [-]: the initial count times
///   1 + 590 stress / (limit stress of a grain of d50),
/// with the highest axial stress of the program. The slope is half as much again as runs of
/// fontainebleau-ne34 reach (21.7 to 150 MPa, tests/system/results). A strain or a ratio as target leaves the
/// stress open: after isotropic loading it counts as four times that stress, else as 100 MPa; that of another
/// job's specimen as at least 30 MPa.
double crushed_particle_count(const Experiment& experiment);

}  // namespace creep
