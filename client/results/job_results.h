// What lies in a job directory: tables, summary and job file, finished or not.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json.hpp>

#include "absl/status/statusor.h"
#include "core/analysis/number_table.h"
#include "core/experiment/experiment.h"

namespace creepctl {

using creep::NumberTable;

struct JobResults {
  std::filesystem::path directory;
  std::string name;                             ///< of the job file, else of the directory
  std::string job_text;                         ///< job.toml as it stands
  std::optional<creep::Experiment> experiment;  ///< if job.toml can be read by this version
  NumberTable samples;
  NumberTable stages;
  NumberTable breakages;
  NumberTable grading;
  nlohmann::ordered_json summary;  ///< an object; empty while the run has not ended

  /// A figure of summary.json; nullopt if it is not there.
  std::optional<double> figure(std::string_view name) const;
  /// A text of summary.json, "" if it is not there.
  std::string text(std::string_view name) const;
};

/// Errors: NotFound if there is no such directory; InvalidArgument if it holds no job (no job.toml) or a
/// damaged table; the file system's own.
absl::StatusOr<JobResults> read_job_results(const std::filesystem::path& directory);

}  // namespace creepctl
