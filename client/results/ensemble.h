// Jobs that differ in nothing but the seed, and what they say together.
//
// Means are over the seeds, with Student's 95 % interval. What scatters by factors, rates and times to
// failure, is averaged as a logarithm: its mean is the geometric one, and its interval is not symmetric about
// it.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "client/report/overlay.h"
#include "core/analysis/ensemble_mean.h"

namespace creepctl {

struct Ensemble {
  std::string label;              ///< name of the jobs; no two alike
  std::vector<ComparedJob> runs;  ///< ended ones, of different seeds
  std::size_t unfinished = 0;     ///< left out: their strains would be those so far
  std::size_t repeated = 0;       ///< left out: of a seed that is there already
};

/// Each directory that holds a job, and of any other all jobs below it, in the order of their paths. Error:
/// NotFound, InvalidArgument (no job in it), with the directory.
absl::StatusOr<std::vector<std::string>> job_directories(const std::vector<std::string>& given);

/// Whether it is no job's directory but has jobs in it.
bool is_folder_of_jobs(const std::string& directory);

/// Groups jobs whose experiments are equal but for the seed, in the order of the first of each. Of a job with
/// [start] the name counts too, since the job it starts from may differ. Jobs without a creep stage, such as
/// trunks, are left out if others have one.
std::vector<Ensemble> group_by_seed(std::vector<ComparedJob> jobs);

/// The jobs of job_directories(), grouped. Error: of that, and of read_job_results().
absl::StatusOr<std::vector<Ensemble>> read_ensembles(const std::vector<std::string>& given);

struct EnsembleFigures {
  using Mean = std::optional<creep::EnsembleMean>;
  Mean void_ratio_before;                  ///< when the hold began [-]
  Mean creep_strain;                       ///< at the end [-]
  Mean m;                                  ///< Singh-Mitchell slope [-]
  Mean ln_rate_10_min;                     ///< ln of the rate of that fit in %/min
  Mean grading_index;                      ///< at the end [-]
  Mean stages;                             ///< ageing jumps
  Mean ln_time_to_failure;                 ///< ln of seconds, of the runs that failed in creep
  std::size_t extrapolated = 0;            ///< runs whose fit does not reach 10 min
  std::optional<TriaxialCreepTest> paper;  ///< the test of Table 2 of which all runs are trials
};

EnsembleFigures ensemble_figures(const Ensemble& ensemble);

/// "0.592 ± 0.006", decimals after the half width; "0.5923" of one run; "–" of none.
std::string mean_text(const EnsembleFigures::Mean& mean, double factor = 1.0);

/// "0.0021 (0.0012 to 0.0035)" of a mean of logarithms.
std::string geometric_mean_text(const EnsembleFigures::Mean& mean);

/// A sentence on what the means are worth: over how many seeds, or that one run has no uncertainty.
std::string confidence_note(const std::vector<Ensemble>& ensembles);

}  // namespace creepctl
