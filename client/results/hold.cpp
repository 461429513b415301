#include "client/results/hold.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <variant>

#include "absl/strings/str_format.h"
#include "core/output/record.h"

namespace creepctl {
namespace {

/// Axial strain when the hold began: at the end of the loading before it, else where its own samples begin.
double strain_before(const JobResults& results, const Hold& hold) {
  double strain = 0.0;
  bool found = false;
  for (std::size_t row = 0; row < results.stages.rows(); ++row) {
    const bool before = results.stages.at(row, "stage") < hold.program_stage;
    if (!before || !std::isfinite(results.stages.at(row, "axial_strain_end"))) continue;
    strain = results.stages.at(row, "axial_strain_end");
    found = true;
  }
  if (found) return strain;
  for (std::size_t row = 0; row < results.samples.rows(); ++row) {
    if (results.samples.at(row, "stage") >= hold.program_stage) break;
    strain = results.samples.at(row, "axial_strain");
    found = true;
  }
  if (found || hold.sample_rows.empty()) return strain;
  return results.samples.at(hold.sample_rows.front(), "axial_strain");
}

bool near(double value, double wanted, double tolerance) { return std::fabs(value - wanted) <= tolerance; }

bool is_paper_grading(const creep::Grading& grading) {
  const auto* lognormal = std::get_if<creep::LognormalGrading>(&grading);
  const creep::LognormalGrading paper;
  return lognormal != nullptr && lognormal->median_diameter == paper.median_diameter &&
         lognormal->log_standard_deviation == paper.log_standard_deviation &&
         lognormal->min_diameter == paper.min_diameter && lognormal->max_diameter == paper.max_diameter;
}

}  // namespace

namespace {

/// The last hold of a stage of the program that `wanted` takes.
std::optional<Hold> last_hold_of(const JobResults& results, const std::function<bool(double)>& wanted) {
  Hold hold;
  bool found = false;
  const auto see = [&](double program_stage) {
    if (!wanted(program_stage)) return;
    hold.program_stage = found ? std::max(hold.program_stage, program_stage) : program_stage;
    found = true;
  };
  const double dynamic = static_cast<double>(creep::Phase::kDynamicStage);
  for (std::size_t row = 0; row < results.stages.rows(); ++row) {
    if (results.stages.at(row, "dynamic_stage") >= 0.0) see(results.stages.at(row, "stage"));
  }
  for (std::size_t row = 0; row < results.samples.rows(); ++row) {
    if (results.samples.at(row, "phase") >= dynamic) see(results.samples.at(row, "stage"));
  }
  if (!found) return std::nullopt;

  for (std::size_t row = 0; row < results.samples.rows(); ++row) {
    const bool creeping = results.samples.at(row, "phase") >= dynamic;
    if (creeping && results.samples.at(row, "stage") == hold.program_stage) hold.sample_rows.push_back(row);
  }
  hold.strain_before = strain_before(results, hold);
  creep::CreepCurve grading_index;
  for (std::size_t row = 0; row < results.stages.rows(); ++row) {
    const bool creeping = results.stages.at(row, "dynamic_stage") >= 0.0;
    if (!creeping || results.stages.at(row, "stage") != hold.program_stage) continue;
    hold.stage_rows.push_back(row);
    hold.curve.creep_time.push_back(results.stages.at(row, "creep_time_end_s"));
    hold.curve.axial_strain.push_back(results.stages.at(row, "axial_strain_end") - hold.strain_before);
    grading_index.creep_time.push_back(results.stages.at(row, "creep_time_end_s"));
    grading_index.axial_strain.push_back(results.stages.at(row, "grading_index_end"));
  }
  hold.analysis = creep::analyse_creep(hold.curve);
  hold.grading_index_fit = creep::fit_log_time(grading_index);
  return hold;
}

bool is_relaxation_stage(const JobResults& results, double program_stage) {
  if (!results.experiment) return false;
  const auto& program = results.experiment->program;
  const auto place = static_cast<std::size_t>(program_stage);
  return place < program.size() && std::holds_alternative<creep::RelaxationStage>(program[place]);
}

}  // namespace

std::optional<Hold> last_hold(const JobResults& results) {
  return last_hold_of(results, [&](double stage) { return !is_relaxation_stage(results, stage); });
}

std::optional<Hold> last_relaxation(const JobResults& results) {
  return last_hold_of(results, [&](double stage) { return is_relaxation_stage(results, stage); });
}

std::vector<std::size_t> loading_and_creep_samples(const JobResults& results) {
  std::vector<std::size_t> rows;
  for (std::size_t row = 0; row < results.samples.rows(); ++row) {
    if (results.samples.at(row, "phase") <= static_cast<double>(creep::Phase::kPacking)) continue;
    // The last sample of packing is the state where strains are zero.
    if (rows.empty() && row > 0) rows.push_back(row - 1);
    rows.push_back(row);
  }
  return rows;
}

PaperScene paper_scene(const JobResults& results) {
  PaperScene scene;
  if (!results.experiment) return scene;
  const creep::Experiment& asked = *results.experiment;
  if (asked.program.empty() || asked.program.size() > 2) return scene;
  const auto* loading = std::get_if<creep::OedometricStage>(&asked.program[0]);
  // 0.5 % of the stress is what a stage settles to; 0.002 what packing may miss of e.
  scene.compression = loading != nullptr &&
                      near(loading->until.value, kPaperAxialStress, 0.005 * kPaperAxialStress) &&
                      near(asked.specimen.void_ratio, kPaperInitialVoidRatio, 0.002) &&
                      is_paper_grading(asked.specimen.grading);
  if (!scene.compression || asked.program.size() < 2) return scene;
  const auto* creeping = std::get_if<creep::CreepStage>(&asked.program[1]);
  scene.creep =
      creeping != nullptr && near(creeping->duration, kPaperDuration, 0.05 * kPaperDuration) &&
      near(creeping->axial_stress.value_or(kPaperAxialStress), kPaperAxialStress, 0.005 * kPaperAxialStress);
  return scene;
}

std::string duration_text(double seconds) {
  if (!std::isfinite(seconds)) return "–";
  if (seconds >= 86400.0) return absl::StrFormat("%.3g d", seconds / 86400.0);
  if (seconds >= 3600.0) return absl::StrFormat("%.3g h", seconds / 3600.0);
  if (seconds >= 60.0) return absl::StrFormat("%.3g min", seconds / 60.0);
  if (seconds >= 1.0 || seconds == 0.0) return absl::StrFormat("%.3g s", seconds);
  if (seconds >= 1e-3) return absl::StrFormat("%.3g ms", seconds * 1e3);
  return absl::StrFormat("%.3g µs", seconds * 1e6);
}

}  // namespace creepctl
