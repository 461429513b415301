#include <algorithm>
#include <array>

#include "core/experiment/read_target.h"
#include "core/experiment/sections.h"
#include "core/experiment/table_reader.h"
#include "core/experiment/wording.h"

namespace creep {
namespace {

using Measure = Target::Measure;

constexpr std::array<std::string_view, 6> kStageWords = {"oedometric", "isotropic", "triaxial",
                                                         "unload",     "creep",     "relaxation"};
constexpr std::size_t kMostStages = 100;
constexpr double kShortestHold = 1e-3;                      // [s]
constexpr double kLongestHold = 1000.0 * 365.25 * 86400.0;  // [s]

/// What is known of the specimen while the stages are read in order.
struct Loading {
  bool loaded = false;     ///< a loading stage came before, good or not, or a checkpoint is started from
  bool sides_held = true;  ///< the sides hold a stress, or it is not known whether they do
  std::optional<double> axial_stress;   ///< [Pa]
  std::optional<double> radial_stress;  ///< [Pa]

  void forget() { *this = {.loaded = true, .sides_held = true, .axial_stress = {}, .radial_stress = {}}; }
};

/// Reads one kind of stage after the other; `loading` follows what they do.
class StageReader {
 public:
  StageReader(TableReader& reader, Loading& loading, DiagnosticLog& log)
      : reader_(reader), loading_(loading), log_(log) {}

  std::optional<Stage> oedometric();
  std::optional<Stage> isotropic();
  std::optional<Stage> triaxial();
  std::optional<Stage> unload();
  std::optional<Stage> creep();
  std::optional<Stage> relaxation();

 private:
  /// The error of a stress that is on the wrong side of the one reached before, if that is known.
  void check_side(const Target& until, std::optional<double> reached, bool rising);
  void error_in_until(Measure measure, const std::string& message);
  std::optional<double> duration(std::string_view stage);
  std::optional<double> mean_stress() const;
  std::optional<double> deviatoric_stress() const;

  TableReader& reader_;
  Loading& loading_;
  DiagnosticLog& log_;
};

std::optional<double> StageReader::mean_stress() const {
  if (!loading_.axial_stress || !loading_.radial_stress) return std::nullopt;
  return (*loading_.axial_stress + 2.0 * *loading_.radial_stress) / 3.0;
}

std::optional<double> StageReader::deviatoric_stress() const {
  if (!loading_.axial_stress || !loading_.radial_stress) return std::nullopt;
  return *loading_.axial_stress - *loading_.radial_stress;
}

void StageReader::error_in_until(Measure measure, const std::string& message) {
  const DocumentEntry* until = reader_.table().find("until");
  const bool as_ratio = measure == Measure::kDeviatoricStress && until->value.find("q_ratio") != nullptr;
  const DocumentEntry* entry = until->value.find(as_ratio ? "q_ratio" : measure_name(measure));
  log_.error(entry == nullptr ? until->value.begin : entry->value.begin, message);
}

void StageReader::check_side(const Target& until, std::optional<double> reached, bool rising) {
  if (!reached || (rising ? until.value > *reached : until.value < *reached)) return;
  error_in_until(until.measure, std::string(measure_name(until.measure)) + " must be " +
                                    (rising ? "above" : "below") + " the " +
                                    format_quantity(*reached, Dimension::kStress) + " reached before" +
                                    (rising ? "; to go back there is the stage \"unload\"" : ""));
}

std::optional<Stage> StageReader::oedometric() {
  constexpr std::array kMeasures = {Measure::kAxialStress, Measure::kAxialStrain};
  const auto until = read_until(reader_, kMeasures, "{ axial_stress = \"21.7 MPa\" }", log_);
  const auto keep = read_keep(reader_, true, log_);
  const auto reached = loading_.axial_stress;
  loading_.forget();
  loading_.sides_held = false;
  if (!until) return std::nullopt;
  if (until->measure == Measure::kAxialStress) {
    check_side(*until, reached, true);
    loading_.axial_stress = until->value;
  }
  return OedometricStage{*until, keep};
}

std::optional<Stage> StageReader::isotropic() {
  constexpr std::array kMeasures = {Measure::kMeanStress};
  const auto until = read_until(reader_, kMeasures, "{ mean_stress = \"10 MPa\" }", log_);
  const auto keep = read_keep(reader_, true, log_);
  const auto reached = mean_stress();
  loading_.forget();
  if (!until) return std::nullopt;
  check_side(*until, reached, true);
  loading_.axial_stress = loading_.radial_stress = until->value;
  return IsotropicStage{*until, keep};
}

std::optional<Stage> StageReader::triaxial() {
  constexpr std::array kMeasures = {Measure::kAxialStrain, Measure::kDeviatoricStrain,
                                    Measure::kDeviatoricStress, Measure::kStressRatio, Measure::kAxialStress};
  TriaxialStage stage;
  const auto until = read_until(reader_, kMeasures, "{ deviatoric_strain = 0.3 }", log_);
  reader_.quantity("radial_stress", Dimension::kStress, kLeastStress, kLargestStress, stage.radial_stress);
  reader_.quantity("axial_velocity", Dimension::kVelocity, 1e-6, 10.0, stage.axial_velocity);
  stage.keep = read_keep(reader_, true, log_);
  const bool were_held = loading_.sides_held;
  const Loading before = loading_;
  loading_.forget();
  loading_.radial_stress = stage.radial_stress;
  if (!stage.radial_stress && were_held) loading_.radial_stress = before.radial_stress;
  if (!until) return std::nullopt;
  stage.until = *until;
  const bool same_sides = loading_.radial_stress == before.radial_stress;
  if (until->measure == Measure::kAxialStress) {
    check_side(*until, before.axial_stress, true);
    loading_.axial_stress = until->value;
  } else if (until->measure == Measure::kDeviatoricStress && loading_.radial_stress) {
    if (same_sides && before.axial_stress) {
      check_side(*until, *before.axial_stress - *before.radial_stress, true);
    }
    loading_.axial_stress = *loading_.radial_stress + until->value;
  }
  return stage;
}

std::optional<Stage> StageReader::unload() {
  constexpr std::array kMeasures = {Measure::kAxialStress, Measure::kDeviatoricStress, Measure::kMeanStress};
  const auto until = read_until(reader_, kMeasures, "{ axial_stress = \"1 MPa\" }", log_);
  const auto keep = read_keep(reader_, true, log_);
  if (!loading_.loaded) {
    reader_.error(reader_.table().begin, "unload needs a loading stage before it");
  } else if (until && until->measure == Measure::kAxialStress) {
    check_side(*until, loading_.axial_stress, false);
    loading_.axial_stress = until->value;
  } else if (until && until->measure == Measure::kMeanStress) {
    check_side(*until, mean_stress(), false);
    loading_.axial_stress = loading_.radial_stress = until->value;
    loading_.sides_held = true;
  } else if (until && !loading_.sides_held) {
    error_in_until(until->measure, "the sides are fixed after an oedometric stage: give axial_stress");
  } else if (until) {
    check_side(*until, deviatoric_stress(), false);
    if (loading_.radial_stress) loading_.axial_stress = *loading_.radial_stress + until->value;
  }
  if (!until) return std::nullopt;
  return UnloadStage{*until, keep};
}

std::optional<double> StageReader::duration(std::string_view stage) {
  std::optional<double> duration;
  reader_.quantity("duration", Dimension::kDuration, kShortestHold, kLongestHold, duration);
  if (!reader_.has("duration")) {
    reader_.error(reader_.table().begin, "a " + std::string(stage) + " stage needs duration, like \"2 d\"");
  }
  if (!loading_.loaded) {
    reader_.error(reader_.table().begin,
                  std::string(stage) + " needs a loading stage before it: nothing is loaded yet");
  }
  return duration;
}

std::optional<Stage> StageReader::creep() {
  const auto time = duration("creep");
  std::optional<double> axial_stress;
  reader_.quantity("axial_stress", Dimension::kStress, kLeastStress, kLargestStress, axial_stress);
  const auto deviatoric_stress = read_deviatoric_stress(reader_, kLeastStress);
  const std::string_view q_key = reader_.has("q_ratio") ? "q_ratio" : "deviatoric_stress";
  if (reader_.has("axial_stress") && reader_.has(q_key)) {
    reader_.error(reader_.position_of(q_key), "give either axial_stress or a deviatoric stress, not both");
  } else if (reader_.has(q_key) && loading_.loaded && !loading_.sides_held) {
    reader_.error(
        reader_.position_of(q_key),
        "the sides are fixed after an oedometric stage: give axial_stress, or load by isotropic and "
        "triaxial stages");
  }
  const auto keep = read_keep(reader_, false, log_);
  if (axial_stress) loading_.axial_stress = axial_stress;
  if (deviatoric_stress && loading_.radial_stress) {
    loading_.axial_stress = *loading_.radial_stress + *deviatoric_stress;
  }
  if (!time) return std::nullopt;
  return CreepStage{*time, axial_stress, deviatoric_stress, keep};
}

std::optional<Stage> StageReader::relaxation() {
  const auto time = duration("relaxation");
  const auto keep = read_keep(reader_, false, log_);
  loading_.axial_stress = std::nullopt;
  if (!time) return std::nullopt;
  return RelaxationStage{*time, keep};
}

std::optional<Stage> read_stage(const DocumentNode& table, Loading& loading, DiagnosticLog& log) {
  TableReader reader(table, "[[program]]", log);
  const auto word = reader.word("stage", kStageWords);
  if (!word) {
    if (!reader.has("stage")) {
      reader.error(table.begin, "a [[program]] entry needs stage (allowed: " + listed(kStageWords) + ")");
    }
    loading.forget();  // a load may have been meant: no further complaint about a missing one
    return std::nullopt;
  }
  using Read = std::optional<Stage> (StageReader::*)();
  constexpr std::array<Read, kStageWords.size()> kReaders = {
      &StageReader::oedometric, &StageReader::isotropic, &StageReader::triaxial,
      &StageReader::unload,     &StageReader::creep,     &StageReader::relaxation};
  StageReader stage_reader(reader, loading, log);
  std::optional<Stage> stage = (stage_reader.*kReaders[*word])();
  reader.finish();
  return stage;
}

}  // namespace

std::vector<Stage> read_program(const DocumentNode& stages, std::optional<double> isotropic_stress,
                                DiagnosticLog& log) {
  std::vector<Stage> program;
  const bool tables = stages.kind == DocumentNode::Kind::kArray && !stages.items.empty() &&
                      std::all_of(stages.items.begin(), stages.items.end(), [](const DocumentNode& item) {
                        return item.kind == DocumentNode::Kind::kTable;
                      });
  if (!tables) {
    log.error(stages.begin, "the program is a list of stages: write each under its own [[program]]");
    return program;
  }
  if (stages.items.size() > kMostStages) {
    log.error(stages.items[kMostStages].begin,
              "a program has at most " + std::to_string(kMostStages) + " stages");
    return program;
  }
  Loading loading;
  loading.axial_stress = loading.radial_stress = isotropic_stress;
  loading.loaded = !isotropic_stress;
  for (const DocumentNode& item : stages.items) {
    if (const auto stage = read_stage(item, loading, log)) program.push_back(*stage);
  }
  return program;
}

}  // namespace creep
