#include "core/experiment/experiment_toml.h"

#include <algorithm>
#include <tuple>

#include "core/experiment/document.h"
#include "core/experiment/fidelity.h"
#include "core/experiment/sections.h"
#include "core/experiment/table_reader.h"
#include "core/experiment/wording.h"

namespace creep {
namespace {

constexpr std::size_t kMostDiagnostics = 100;
constexpr std::size_t kLongestName = 200;     // bytes
constexpr std::size_t kLongestSource = 4000;  // bytes, of the path of a folder

/// The table of a section; null (and an error if it is there as something else) otherwise.
const DocumentNode* section(TableReader& root, std::string_view key) {
  const DocumentNode* node = root.find(key);
  if (node == nullptr || node->kind == DocumentNode::Kind::kTable) return node;
  root.error(node->begin, std::string(key) + " is a section: write [" + std::string(key) + "]");
  return nullptr;
}

/// A text that programs print: one line. Empty if it is not there.
std::string one_line(TableReader& reader, std::string_view key, std::size_t longest) {
  const std::optional<std::string> text = reader.string(key);
  if (!text) return "";
  std::string shown = printable(*text);
  if (shown == *text && text->size() <= longest) return shown;
  reader.error(reader.position_of(key), std::string(key) + " must be one line of at most " +
                                            std::to_string(longest) + " bytes, without control characters");
  return shown;
}

Start read_start(const DocumentNode& table, DiagnosticLog& log) {
  TableReader reader(table, "[start]", log);
  Start start;
  start.job = one_line(reader, "job", kLongestSource);
  if (start.job.empty()) {
    reader.error(reader.position_of("job"),
                 "[start] needs job: the id of a job, or for creepctl run its folder");
  }
  start.checkpoint = one_line(reader, "checkpoint", kLongestName);
  reader.finish();
  return start;
}

void check_together(const DocumentNode& root, const Experiment& experiment, DiagnosticLog& log) {
  const auto& ageing = experiment.numerics.breakages_per_ageing;
  const auto& particles = experiment.specimen.particles;
  if (ageing && particles && *ageing > *particles) {
    log.error(root.find("numerics")->value.find("breakages_per_ageing")->value.begin,
              "breakages_per_ageing must not exceed the number of particles");
  }
  const DocumentEntry* numerics = root.find("numerics");
  const DocumentEntry* fidelity = numerics != nullptr ? numerics->value.find("fidelity") : nullptr;
  if (fidelity != nullptr && fidelity->value.kind == DocumentNode::Kind::kTable && particles &&
      *particles < kMeasuredParticles) {
    log.warning(fidelity->value.begin, "errors were measured on specimens of " +
                                           std::to_string(kMeasuredParticles) +
                                           " particles; those of smaller ones are larger");
  }
}

Experiment read_experiment(const DocumentNode& document, DiagnosticLog& log) {
  Experiment experiment;
  TableReader root(document, "the job file", log);
  experiment.name = one_line(root, "name", kLongestName);
  if (const DocumentNode* start = section(root, "start")) experiment.start = read_start(*start, log);
  if (const DocumentNode* specimen = section(root, "specimen")) {
    experiment.specimen = read_specimen(*specimen, log);
  } else if (!root.has("specimen") && !root.has("start")) {
    log.error({}, "missing section [specimen]");
  }
  if (const DocumentNode* material = section(root, "material")) {
    experiment.material = read_material(*material, log);
  }
  if (const DocumentNode* program = root.find("program")) {
    experiment.program = read_program(
        *program, experiment.start ? std::nullopt : std::optional(experiment.specimen.isotropic_stress), log);
  } else {
    log.error({}, "missing [[program]]: the job has no stage");
  }
  if (const DocumentNode* numerics = section(root, "numerics")) {
    experiment.numerics = read_numerics(*numerics, log);
  }
  if (const DocumentNode* output = section(root, "output")) experiment.output = read_output(*output, log);
  root.finish();
  check_together(document, experiment, log);
  return experiment;
}

/// Returns how many the last of them stands for, if they were cut.
std::size_t sort_and_cut(std::vector<Diagnostic>& diagnostics) {
  std::stable_sort(diagnostics.begin(), diagnostics.end(), [](const Diagnostic& a, const Diagnostic& b) {
    return std::tie(a.line, a.column) < std::tie(b.line, b.column);
  });
  if (diagnostics.size() <= kMostDiagnostics) return 0;
  const std::size_t more = diagnostics.size() - kMostDiagnostics;
  diagnostics.resize(kMostDiagnostics);
  const Diagnostic last = diagnostics.back();
  diagnostics.push_back({last.line, last.column, "and " + std::to_string(more) + " more like these"});
  return more;
}

/// The byte offset of a place in the text.
std::size_t offset_of(std::string_view text, TextPosition position) {
  std::size_t at = 0;
  for (int line = 1; line < position.line && at < text.size(); ++line) {
    at = std::min(text.find('\n', at), text.size() - 1) + 1;
  }
  const auto continues = [&] {
    return at < text.size() && (static_cast<unsigned char>(text[at]) & 0xC0U) == 0x80U;
  };
  for (int column = 1; column < position.column && at < text.size(); ++column) {
    ++at;
    while (continues()) ++at;
  }
  return at;
}

}  // namespace

ParseResult parse_experiment(std::string_view text) {
  ParseResult result;
  const ParsedDocument document = parse_document(text);
  if (document.error) {
    result.errors.push_back(*document.error);
    return result;
  }
  if (document.root.entries.empty()) {
    result.errors.push_back({1, 1, "the file is empty; 'creepctl init' writes a job file to start from"});
    return result;
  }
  DiagnosticLog log;
  Experiment experiment = read_experiment(document.root, log);
  result.more_errors = sort_and_cut(log.errors);
  sort_and_cut(log.warnings);
  if (log.errors.empty()) result.experiment = std::move(experiment);
  result.errors = std::move(log.errors);
  result.warnings = std::move(log.warnings);
  return result;
}

std::optional<GradingFile> find_grading_file(std::string_view text) {
  const ParsedDocument document = parse_document(text);
  if (document.error) return std::nullopt;
  const DocumentEntry* entry = document.root.find("specimen");
  for (const std::string_view key : {"grading", "file"}) {
    if (entry != nullptr) entry = entry->value.find(key);
  }
  if (entry == nullptr || entry->value.kind != DocumentNode::Kind::kString) return std::nullopt;
  return GradingFile{.path = entry->value.string,
                     .value_position = entry->value.begin,
                     .key_begin = offset_of(text, entry->key_begin),
                     .key_end = offset_of(text, entry->key_end),
                     .value_begin = offset_of(text, entry->value.begin),
                     .value_end = offset_of(text, entry->value.end)};
}

}  // namespace creep
