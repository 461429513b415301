// The charts of a job, from what its directory holds so far.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "client/charts/chart.h"
#include "client/results/hold.h"
#include "client/results/job_results.h"

namespace creepctl {

struct NamedChart {
  std::string file_stem;  ///< "void_ratio_log_stress"
  std::string caption;    ///< one or two sentences: what is drawn and by which rule
  Chart chart;
};

/// Every chart there is data for, in the order of the report.
std::vector<NamedChart> result_charts(const JobResults& results, const std::optional<Hold>& hold);

}  // namespace creepctl
