// The job file: TOML text -> Experiment, or everything that is wrong with it at once.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/experiment/diagnostic.h"
#include "core/experiment/experiment.h"

namespace creep {

struct ParseResult {
  std::optional<Experiment> experiment;  ///< there exactly when `errors` is empty
  std::vector<Diagnostic> errors;        ///< in the order of the text
  std::size_t more_errors = 0;           ///< for which the last of `errors` stands; 0: all are told
  std::vector<Diagnostic> warnings;      ///< in the order of the text
};

/// Parses and validates a job file of any bytes. Keys that are left out have the defaults of experiment.h;
/// only [specimen] with particles or side, and one [[program]], must be there. With [start] the specimen may
/// be left out as well: complete the text from the source's first (job_text.h).
ParseResult parse_experiment(std::string_view text);

/// A `grading = { file = "psd.csv" }` of a job file: which bytes of the text are the key and the value.
/// Whoever sends the job replaces them by `points` and an array of points.
struct GradingFile {
  std::string path;
  TextPosition value_position;
  std::size_t key_begin = 0;  ///< byte offsets into the text, ends exclusive
  std::size_t key_end = 0;
  std::size_t value_begin = 0;
  std::size_t value_end = 0;
};

/// None if there is no such key or the text is no TOML.
std::optional<GradingFile> find_grading_file(std::string_view text);

}  // namespace creep
