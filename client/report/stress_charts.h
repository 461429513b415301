// The charts of triaxial loading and of relaxation.
#pragma once

#include <vector>

#include "client/report/result_charts.h"

namespace creepctl {

/// q and volumetric strain over axial strain, if the job has a triaxial stage; and the decay of the axial
/// stress in its last relaxation.
std::vector<NamedChart> stress_charts(const JobResults& results);

}  // namespace creepctl
