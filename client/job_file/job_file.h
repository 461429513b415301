// A job file as the commands read it: checked, and made whole by putting in the gradings it refers to.
#pragma once

#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "core/experiment/experiment_toml.h"
#include "core/experiment/job_text.h"

namespace creepctl {

/// One diagnostic with the file it is about.
struct FileDiagnostic {
  std::string file;
  creep::Diagnostic diagnostic;
};

struct JobFile {
  std::string path;
  std::string text;  ///< with the points of a grading file put in: what a worker gets
  std::optional<creep::Experiment> experiment;  ///< there exactly when `errors` is empty
  std::vector<FileDiagnostic> errors;
  std::vector<FileDiagnostic> warnings;
};

/// Reads, completes and checks a job file. What cannot be read is an error at 1:1. A grading file's path is
/// relative to the job file. With overrides it is the text with them that is checked and given; what is wrong
/// with that is at 1:1, since nobody sees its lines. Writes and prints nothing.
JobFile read_job_file(const std::string& path, const std::vector<creep::Override>& overrides = {});

/// The overrides of --set KEY=VALUE options. Error: InvalidArgument, with the one that is none.
absl::StatusOr<std::vector<creep::Override>> parse_overrides(const std::vector<std::string>& settings);

/// Prints `FILE:LINE:COL: error: ...` and `...: warning: ...` on stderr.
void print_diagnostics(const JobFile& job);

}  // namespace creepctl
