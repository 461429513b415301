// What lies in a job directory: tables, summary and job file, finished or not.
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json.hpp>

#include "absl/status/statusor.h"
#include "core/experiment/experiment.h"

namespace creepctl {

/// A csv table of numbers, read by column name: further columns are kept, missing ones are empty.
class NumberTable {
 public:
  NumberTable() = default;

  /// `name` is for messages. A last line without its newline is still being written and is left out.
  /// Error: InvalidArgument for a line of another length than the header or a cell that is no number.
  static absl::StatusOr<NumberTable> parse(std::string_view text, std::string_view name);

  std::size_t rows() const { return columns_.empty() ? 0 : columns_.front().size(); }
  bool has(std::string_view column) const;

  /// The values of a column; empty if there is none of that name.
  const std::vector<double>& column(std::string_view name) const;

  /// One value; NaN if there is no such column or row, which charts and tables leave out.
  double at(std::size_t row, std::string_view column) const;

 private:
  std::vector<std::string> names_;
  std::vector<std::vector<double>> columns_;
};

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
