// Failed particles become 14 spheres each (section 2.2.1). Mass is conserved: what the siblings lack becomes
// fines.
#pragma once

#include <vector>

#include "core/dem/dynamics.h"
#include "core/dem/specimen.h"
#include "core/experiment/experiment.h"

namespace creep {

/// Replaces the failed particles, in ascending index, and makes the contact list anew.
///
/// Siblings inherit the velocity and get new ids, strengths and cracks; local z lies along the normal of the
/// parent's largest normal contact force (ties: the first in neighbour order), the azimuth is drawn by the
/// parent's id. The elastic and kinetic energy that goes with a parent is booked as removed.
/// @param failures  ascending index, each particle once; the list and the contact forces are those of the
/// last cycle.
void split(Specimen& specimen, const Experiment& experiment, Dynamics& dynamics,
           const std::vector<Failure>& failures);

}  // namespace creep
