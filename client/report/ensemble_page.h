// The report of several jobs: one HTML page with means over the seeds.
#pragma once

#include <string>
#include <vector>

#include "client/results/ensemble.h"

namespace creepctl {

std::string ensemble_page(const std::string& title, const std::vector<Ensemble>& ensembles);

}  // namespace creepctl
