// The charts of ensembles: mean curves with their confidence bands.
#pragma once

#include <vector>

#include "client/report/result_charts.h"
#include "client/results/ensemble.h"

namespace creepctl {

/// Strain, log rate and I_G over log creep time, each with the mean of every ensemble and the 95 % band of
/// that mean (none of one run), behind them the runs if there is one ensemble; rate at 10 min over the stress
/// ratio if two ensembles are trials of the paper's Table 2. Laboratory curves go with the strain. Charts
/// without a curve are left out.
std::vector<NamedChart> ensemble_charts(const std::vector<Ensemble>& ensembles,
                                        const std::vector<LaboratoryCurve>& laboratory);

}  // namespace creepctl
