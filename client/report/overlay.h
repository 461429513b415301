// Several jobs in one picture and one table.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "client/laboratory/laboratory_curve.h"
#include "client/report/result_charts.h"
#include "client/results/hold.h"
#include "client/results/job_results.h"
#include "client/results/paper_table_2.h"

namespace creepctl {

struct ComparedJob {
  std::string label;  ///< in legend and table; no two alike
  JobResults results;
  std::optional<Hold> hold;  ///< its last creep stage
};

/// Reads each directory; two jobs of one name are told apart by their directories. Error: of
/// read_job_results(), with the directory.
absl::StatusOr<std::vector<ComparedJob>> read_compared_jobs(const std::vector<std::string>& directories);

/// Creep strain and grading index over log creep time, void ratio over log stress: each with a curve for
/// every job that has one, the first also with the laboratory's. Charts without a curve are left out.
std::vector<NamedChart> overlay_charts(const std::vector<ComparedJob>& jobs,
                                       const std::vector<LaboratoryCurve>& laboratory);

/// Figures of one job, each none if it cannot be told.
struct ComparedFigures {
  std::optional<double> void_ratio_before;  ///< when the hold began [-]
  std::optional<double> creep_strain;       ///< at the end, or so far [-]
  std::optional<double> m;                  ///< Singh-Mitchell slope [-]
  std::optional<double> rate_10_min;        ///< of that fit [%/min]
  std::optional<double> grading_index;      ///< at the end, or so far [-]
  std::optional<TriaxialCreepTest> paper;   ///< the test of Table 2 of which the job is a trial
};

ComparedFigures compared_figures(const ComparedJob& job);

}  // namespace creepctl
