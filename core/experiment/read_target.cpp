#include "core/experiment/read_target.h"

#include <algorithm>
#include <array>

#include "core/experiment/wording.h"

namespace creep {
namespace {

using Measure = Target::Measure;

constexpr std::array kAllMeasures = {Measure::kAxialStress,      Measure::kMeanStress,
                                     Measure::kDeviatoricStress, Measure::kStressRatio,
                                     Measure::kAxialStrain,      Measure::kDeviatoricStrain};
constexpr double kLeastStrain = 1e-5;
constexpr double kLargestStrain = 0.45;       // a run gives loading up at 0.5
constexpr double kLargestStressRatio = 2.99;  // q / p with the sides under compression is below 3

bool is_stress(Measure measure) {
  return measure == Measure::kAxialStress || measure == Measure::kMeanStress ||
         measure == Measure::kDeviatoricStress;
}

/// "axial_stress, mean_stress": the words of the measures, q_ratio with the deviatoric stress.
std::string words_of(std::span<const Measure> measures) {
  std::string text;
  for (const Measure measure : measures) {
    text += (text.empty() ? "" : ", ") + std::string(measure_name(measure));
    if (measure == Measure::kDeviatoricStress) text += ", q_ratio with q_max";
  }
  return text;
}

std::optional<double> read_value(TableReader& table, std::string_view key, Measure measure) {
  std::optional<double> value;
  if (is_stress(measure)) {
    table.quantity(key, Dimension::kStress, kLeastStress, kLargestStress, value);
  } else if (measure == Measure::kStressRatio) {
    table.number(key, 0.0, kLargestStressRatio, value);
  } else {
    table.number(key, kLeastStrain, kLargestStrain, value);
  }
  return value;
}

}  // namespace

std::optional<double> read_deviatoric_stress(TableReader& table, double least) {
  std::optional<double> stress, ratio, q_max;
  table.quantity("deviatoric_stress", Dimension::kStress, least, kLargestStress, stress);
  table.number("q_ratio", 0.0, 2.0, ratio);
  table.quantity("q_max", Dimension::kStress, kLeastStress, kLargestStress, q_max);
  if (table.has("deviatoric_stress") && table.has("q_ratio")) {
    table.error(table.position_of("q_ratio"), "give either deviatoric_stress or q_ratio, not both");
  } else if (table.has("q_ratio") != table.has("q_max")) {
    table.error(table.position_of(table.has("q_ratio") ? "q_ratio" : "q_max"),
                "q_ratio and q_max belong together: the deviatoric stress is their product");
  } else if (q_max && ratio) {
    stress = *ratio * *q_max;
    if (*stress >= least) return stress;
    table.error(table.position_of("q_ratio"),
                "q_ratio x q_max must be at least " + format_quantity(least, Dimension::kStress));
    return std::nullopt;
  }
  return stress;
}

std::optional<Target> read_until(TableReader& stage, std::span<const Measure> measures,
                                 std::string_view example, DiagnosticLog& log) {
  const DocumentNode* until = stage.find("until");
  if (until == nullptr || until->kind != DocumentNode::Kind::kTable) {
    stage.error(until == nullptr ? stage.table().begin : until->begin,
                "this stage needs until = " + std::string(example));
    return std::nullopt;
  }
  TableReader reader(*until, "until", log);
  std::optional<Target> target;
  int given = 0;
  for (const Measure measure : kAllMeasures) {
    const std::string_view word = measure_name(measure);
    if (std::find(measures.begin(), measures.end(), measure) == measures.end()) {
      reader.unavailable(word, words_of(measures));
      continue;
    }
    std::optional<double> value;
    if (measure == Measure::kDeviatoricStress) {
      given += reader.has("deviatoric_stress") || reader.has("q_ratio") || reader.has("q_max") ? 1 : 0;
      value = read_deviatoric_stress(reader, 0.0);
    } else {
      given += reader.has(word) ? 1 : 0;
      value = read_value(reader, word, measure);
    }
    if (value) target = Target{*value, measure};
  }
  reader.finish();
  if (until->entries.empty()) reader.error(until->begin, "until needs a target: " + words_of(measures));
  if (given > 1) reader.error(until->begin, "until needs one target, not " + std::to_string(given));
  return given == 1 ? target : std::nullopt;
}

std::optional<Keep> read_keep(TableReader& stage, bool loading, DiagnosticLog& log) {
  const DocumentNode* node = stage.find("keep");
  if (node == nullptr) return std::nullopt;
  if (node->kind != DocumentNode::Kind::kTable) {
    stage.error(node->begin,
                "keep must be a table: { every_axial_strain = 0.005 }, or {} to keep the end only");
    return std::nullopt;
  }
  TableReader reader(*node, "keep", log);
  constexpr std::array<Measure, 3> kSteps = {Measure::kAxialStrain, Measure::kAxialStress,
                                             Measure::kDeviatoricStress};
  constexpr std::array<std::string_view, 3> kWords = {"every_axial_strain", "every_axial_stress",
                                                      "every_deviatoric_stress"};
  constexpr double kLeastStrainStep = 1e-4, kLeastStressStep = 10e3;
  Keep keep;
  for (std::size_t i = 0; i < kSteps.size(); ++i) {
    if (!loading) {
      reader.unavailable(kWords[i], "{}, which keeps the end of the stage");
      continue;
    }
    std::optional<double> step;
    if (is_stress(kSteps[i])) {
      reader.quantity(kWords[i], Dimension::kStress, kLeastStressStep, kLargestStress, step);
    } else {
      reader.number(kWords[i], kLeastStrainStep, kLargestStrain, step);
    }
    if (step) keep = {*step, kSteps[i]};
  }
  reader.finish();
  if (node->entries.size() > 1)
    reader.error(node->begin, "keep takes one step: a checkpoint at each multiple");
  return keep;
}

}  // namespace creep
