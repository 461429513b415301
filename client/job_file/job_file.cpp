#include "client/job_file/job_file.h"

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <memory>

#include "absl/status/statusor.h"
#include "client/laboratory/grading_csv.h"
#include "client/terminal/terminal.h"
#include "core/experiment/wording.h"

namespace creepctl {
namespace {

constexpr std::size_t kLargestFile = 2 * 1024 * 1024;  // bytes; the core refuses less, and says so

struct CloseFile {
  void operator()(std::FILE* file) const { std::fclose(file); }
};

/// The first kLargestFile bytes. Error: Unavailable with the system's reason.
absl::StatusOr<std::string> read_bytes(const std::string& path) {
  const auto refused = [](int error) {
    return absl::UnavailableError(std::string("cannot be read: ") + std::strerror(error));
  };
  std::error_code ignored;
  if (std::filesystem::is_directory(path, ignored)) return refused(EISDIR);
  const std::unique_ptr<std::FILE, CloseFile> file(std::fopen(path.c_str(), "rb"));
  if (file == nullptr) return refused(errno);
  std::string bytes(kLargestFile, '\0');
  bytes.resize(std::fread(bytes.data(), 1, bytes.size(), file.get()));
  if (std::ferror(file.get()) != 0) return refused(errno);
  return bytes;
}

/// Where the points of a grading file now stand in the text, in columns of one line.
struct Insertion {
  std::string file;  ///< "" if there is none
  creep::TextPosition begin;
  int old_end = 0;  ///< columns, exclusive
  int new_end = 0;
};

/// Replaces `file = "psd.csv"` by `points = [...]` on the same line.
Insertion put_in_grading(const creep::GradingFile& grading, JobFile& job) {
  const std::string file = (std::filesystem::path(job.path).parent_path() / grading.path).string();
  const absl::StatusOr<std::string> bytes = read_bytes(file);
  if (!bytes.ok()) {
    const auto at = grading.value_position;
    job.errors.push_back(
        {job.path,
         {at.line, at.column,
          "grading file " + creep::quoted(file) + " " + std::string(bytes.status().message())}});
    return {};
  }
  const GradingCsv csv = read_grading_csv(*bytes);
  for (const creep::Diagnostic& error : csv.errors) job.errors.push_back({file, error});
  if (!csv.errors.empty()) return {};

  const auto old_length = static_cast<int>(grading.value_end - grading.value_begin);
  const auto key_growth = static_cast<int>(std::string_view("points").size()) -
                          static_cast<int>(grading.key_end - grading.key_begin);
  job.text.replace(grading.value_begin, grading.value_end - grading.value_begin, csv.points);
  job.text.replace(grading.key_begin, grading.key_end - grading.key_begin, "points");
  const int begin = grading.value_position.column + key_growth;
  return {.file = file,
          .begin = {grading.value_position.line, begin},
          .old_end = grading.value_position.column + old_length,
          .new_end = begin + static_cast<int>(csv.points.size())};
}

/// A diagnostic about the completed text, placed in the text as the user wrote it.
FileDiagnostic as_written(const JobFile& job, const Insertion& insertion, creep::Diagnostic diagnostic) {
  if (!insertion.file.empty() && diagnostic.line == insertion.begin.line) {
    if (diagnostic.column >= insertion.new_end) {
      diagnostic.column += insertion.old_end - insertion.new_end;
    } else if (diagnostic.column >= insertion.begin.column) {
      diagnostic.message = "in grading file " + creep::quoted(insertion.file) + ": " + diagnostic.message;
      diagnostic.column = insertion.begin.column;
    }
  }
  return {job.path, diagnostic};
}

/// Sets the keys in the completed text and checks it.
void set_all(const std::vector<creep::Override>& overrides, JobFile& job) {
  std::vector<creep::OverrideFault> faults;
  const auto say = [&](const std::string& what) {
    job.errors.push_back({job.path, {1, 1, "with --set: " + what}});
  };
  auto text = creep::with_overrides(job.text, overrides, &faults);
  for (const creep::OverrideFault& fault : faults) say(fault.message);
  if (!text.ok()) {
    if (faults.empty()) say(std::string(text.status().message()));
    return;
  }
  job.text = *std::move(text);
  creep::ParseResult parsed = creep::parse_experiment(job.text);
  for (const creep::Diagnostic& error : parsed.errors) say(error.message);
  for (const creep::Diagnostic& warning : parsed.warnings)
    job.warnings.push_back({job.path, {1, 1, "with --set: " + warning.message}});
  if (job.errors.empty()) job.experiment = std::move(parsed.experiment);
}

}  // namespace

absl::StatusOr<std::vector<creep::Override>> parse_overrides(const std::vector<std::string>& settings) {
  std::vector<creep::Override> overrides;
  for (const std::string& setting : settings) {
    auto parsed = creep::parse_override(setting);
    if (!parsed) return absl::InvalidArgumentError("--set takes KEY=VALUE, not " + setting);
    overrides.push_back(*std::move(parsed));
  }
  return overrides;
}

JobFile read_job_file(const std::string& path, const std::vector<creep::Override>& overrides) {
  JobFile job;
  job.path = path;
  const absl::StatusOr<std::string> bytes = read_bytes(path);
  if (!bytes.ok()) {
    job.errors.push_back({path, {1, 1, std::string(bytes.status().message())}});
    return job;
  }
  job.text = *bytes;
  Insertion insertion;
  if (const auto grading = creep::find_grading_file(job.text)) {
    insertion = put_in_grading(*grading, job);
    if (!job.errors.empty()) {
      // The rest is checked with a grading that is good, so that one look shows all errors.
      job.text.replace(grading->value_begin, grading->value_end - grading->value_begin,
                       "\"fontainebleau-ne34\"");
      job.text.replace(grading->key_begin, grading->key_end - grading->key_begin, "preset");
    }
  }
  if (!overrides.empty()) {
    set_all(overrides, job);
    return job;
  }
  const creep::ParseResult parsed = creep::parse_experiment(job.text);
  for (const auto& error : parsed.errors) job.errors.push_back(as_written(job, insertion, error));
  for (const auto& warning : parsed.warnings) job.warnings.push_back(as_written(job, insertion, warning));
  if (job.errors.empty()) job.experiment = parsed.experiment;
  return job;
}

void print_diagnostics(const JobFile& job) {
  const auto print = [](const std::vector<FileDiagnostic>& diagnostics, const std::string& kind) {
    for (const FileDiagnostic& at : diagnostics) {
      std::fprintf(stderr, "%s:%d:%d: %s %s\n", at.file.c_str(), at.diagnostic.line, at.diagnostic.column,
                   kind.c_str(), at.diagnostic.message.c_str());
    }
  };
  print(job.errors, red("error:", stderr));
  print(job.warnings, yellow("warning:", stderr));
}

}  // namespace creepctl
