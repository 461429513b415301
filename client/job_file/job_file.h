// A job file as the commands read it: checked, and made whole by putting in the gradings it refers to.
#pragma once

#include <string>
#include <vector>

#include "core/experiment/experiment_toml.h"

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
/// relative to the job file. Writes and prints nothing.
JobFile read_job_file(const std::string& path);

/// Prints `FILE:LINE:COL: error: ...` and `...: warning: ...` on stderr.
void print_diagnostics(const JobFile& job);

}  // namespace creepctl
