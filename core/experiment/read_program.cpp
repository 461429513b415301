#include <algorithm>
#include <array>

#include "core/experiment/sections.h"
#include "core/experiment/table_reader.h"
#include "core/experiment/wording.h"

namespace creep {
namespace {

constexpr std::array<std::string_view, 6> kStageWords = {"oedometric", "creep",      "isotropic",
                                                         "triaxial",   "relaxation", "unload"};
constexpr std::size_t kAvailableStages = 2;  // of kStageWords
constexpr std::string_view kAvailableStagesText = "oedometric, creep";
constexpr std::size_t kMostStages = 100;
constexpr double kLargestStress = 1e9;                       // [Pa]
constexpr double kShortestCreep = 1e-3;                      // [s]
constexpr double kLongestCreep = 1000.0 * 365.25 * 86400.0;  // [s]

/// Where the loading stands while the stages are read in order.
struct Loading {
  double axial_stress = 0.0;  ///< reached so far [Pa]
  bool oedometric = false;    ///< an oedometric stage came before, good or not
};

std::optional<Stage> read_oedometric(TableReader& reader, Loading& loading, DiagnosticLog& log) {
  loading.oedometric = true;
  const DocumentNode* until = reader.find("until");
  if (until == nullptr || until->kind != DocumentNode::Kind::kTable) {
    reader.error(until == nullptr ? reader.table().begin : until->begin,
                 "an oedometric stage needs until = { axial_stress = \"21.7 MPa\" }");
    return std::nullopt;
  }
  TableReader target(*until, "until", log);
  std::optional<double> stress;
  target.quantity("axial_stress", Dimension::kStress, 1e3, kLargestStress, stress);
  for (const std::string_view key :
       {"axial_strain", "deviatoric_strain", "deviatoric_stress", "q_ratio", "duration", "void_ratio"}) {
    target.unavailable(key, "axial_stress");
  }
  if (until->entries.empty()) target.error(until->begin, "until needs a target: axial_stress");
  target.finish();
  if (!stress) return std::nullopt;
  if (*stress <= loading.axial_stress) {
    target.error(target.position_of("axial_stress"),
                 "axial_stress must be above the " +
                     format_quantity(loading.axial_stress, Dimension::kStress) +
                     " reached before; unloading is not available in this version");
    return std::nullopt;
  }
  loading.axial_stress = *stress;
  return OedometricStage{*stress};
}

std::optional<Stage> read_creep(TableReader& reader, Loading& loading) {
  CreepStage stage;
  std::optional<double> duration;
  reader.quantity("duration", Dimension::kDuration, kShortestCreep, kLongestCreep, duration);
  reader.quantity("axial_stress", Dimension::kStress, 1e3, kLargestStress, stage.axial_stress);
  for (const std::string_view key : {"deviatoric_stress", "q_ratio", "q_max"}) {
    reader.unavailable(key, "axial_stress, or none to hold the stress reached");
  }
  if (!reader.has("duration")) {
    reader.error(reader.table().begin, "a creep stage needs duration, like \"2 d\"");
  }
  if (!loading.oedometric) {
    reader.error(reader.table().begin, "creep needs an oedometric stage before it: nothing is loaded yet");
  }
  if (stage.axial_stress && *stage.axial_stress < loading.axial_stress) {
    reader.error(reader.position_of("axial_stress"),
                 "axial_stress must not be below the " +
                     format_quantity(loading.axial_stress, Dimension::kStress) +
                     " reached before; unloading is not available in this version");
  }
  if (!duration) return std::nullopt;
  loading.axial_stress = std::max(loading.axial_stress, stage.axial_stress.value_or(0.0));
  stage.duration = *duration;
  return stage;
}

std::optional<Stage> read_stage(const DocumentNode& table, Loading& loading, DiagnosticLog& log) {
  TableReader reader(table, "[[program]]", log);
  const auto word = reader.word("stage", kStageWords);
  if (!word) {
    if (!reader.has("stage")) {
      reader.error(table.begin,
                   "a [[program]] entry needs stage (available: " + std::string(kAvailableStagesText) + ")");
    }
    loading.oedometric = true;  // it may have been meant: no further complaint about a missing load
    return std::nullopt;
  }
  if (*word >= kAvailableStages) {
    reader.error(reader.position_of("stage"),
                 "stage " + quoted(kStageWords[*word]) +
                     " is not available in this version; available: " + std::string(kAvailableStagesText));
    loading.oedometric = true;
    return std::nullopt;
  }
  std::optional<Stage> stage =
      *word == 0 ? read_oedometric(reader, loading, log) : read_creep(reader, loading);
  reader.unavailable("keep", "");
  reader.finish();
  return stage;
}

}  // namespace

std::vector<Stage> read_program(const DocumentNode& stages, double isotropic_stress, DiagnosticLog& log) {
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
  Loading loading{.axial_stress = isotropic_stress, .oedometric = false};
  for (const DocumentNode& item : stages.items) {
    if (const auto stage = read_stage(item, loading, log)) program.push_back(*stage);
  }
  return program;
}

}  // namespace creep
