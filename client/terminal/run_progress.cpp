#include "client/terminal/run_progress.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <variant>

#include "core/experiment/stage_text.h"
#include "core/experiment/units.h"

namespace creepctl {
namespace {

using nlohmann::json;

template <typename... Arguments>
std::string text(const char* format, Arguments... arguments) {
  char buffer[200];
  std::snprintf(buffer, sizeof buffer, format, arguments...);
  return buffer;
}

std::optional<double> number(const json& object, const char* key) {
  const auto found = object.find(key);
  return found != object.end() && found->is_number() ? std::optional(found->get<double>()) : std::nullopt;
}

std::string word(const json& object, const char* key) {
  const auto found = object.find(key);
  return found != object.end() && found->is_string() ? found->get<std::string>() : std::string();
}

const creep::Stage* stage_of(const RunProgress& progress, const creep::Experiment& experiment) {
  const auto index = static_cast<std::size_t>(progress.stage_index);
  return progress.stage_index >= 0 && index < experiment.program.size() ? &experiment.program[index]
                                                                        : nullptr;
}

/// The present stage as a way from `from` to `to`, `fraction` of it gone.
struct Way {
  std::string from;
  std::string to;
  double fraction = 0.0;
};

Way way_of(const RunProgress& progress, const creep::Experiment& experiment) {
  const creep::Stage* stage = stage_of(progress, experiment);
  if (stage == nullptr) return {"", "", progress.stage_fraction};
  if (const creep::Target* until = creep::target_of(*stage)) {
    const bool axial = until->measure == creep::Target::Measure::kAxialStress;
    return {axial ? text("%.3g MPa", progress.axial_stress.value_or(0.0) / 1e6) : "",
            creep::target_text(*until), progress.stage_fraction};
  }
  const double duration = *creep::duration_of(*stage);
  // The first dynamic stages last about a millisecond: the left end of the log scale.
  constexpr double kLeftEnd = 1e-3;  // [s]
  const double creep_time = progress.creep_time.value_or(0.0);
  const double decades = std::log10(std::max(duration / kLeftEnd, 10.0));
  const double passed = creep_time > kLeftEnd ? std::log10(creep_time / kLeftEnd) / decades : 0.0;
  return {short_duration(creep_time), creep::format_quantity(duration, creep::Dimension::kDuration), passed};
}

std::string bar(double fraction, int cells, bool unicode) {
  const int full = static_cast<int>(std::lround(std::clamp(fraction, 0.0, 1.0) * cells));
  std::string out = unicode ? "▕" : "[";
  for (int i = 0; i < cells; ++i) out += i < full ? (unicode ? "█" : "#") : (unicode ? "░" : ".");
  return out + (unicode ? "▏" : "]");
}

int columns_of(std::string_view utf8) {
  return static_cast<int>(std::count_if(utf8.begin(), utf8.end(), [](char c) { return (c & 0xc0) != 0x80; }));
}

}  // namespace

std::optional<RunProgress> parse_run_progress(std::string_view bytes) {
  const json object = json::parse(bytes, nullptr, false);
  if (!object.is_object() || word(object, "stage").empty()) return std::nullopt;
  RunProgress progress;
  progress.stage = word(object, "stage");
  progress.phase = word(object, "phase");
  progress.stage_index = static_cast<std::int64_t>(number(object, "stage_index").value_or(-1.0));
  progress.dynamic_stage = static_cast<std::int64_t>(number(object, "dynamic_stage").value_or(0.0));
  progress.stage_fraction = number(object, "stage_fraction").value_or(0.0);
  if (const auto speed = object.find("particle_steps_per_second");
      speed != object.end() && speed->is_object()) {
    progress.particle_steps_per_second = number(*speed, "recent").value_or(0.0);
  }
  progress.creep_time = number(object, "creep_time_s");
  progress.axial_strain = number(object, "axial_strain");
  progress.axial_stress = number(object, "axial_stress_Pa");
  progress.void_ratio = number(object, "void_ratio");
  progress.grading_index = number(object, "grading_index");
  progress.broken_total = number(object, "broken_total");
  progress.seconds_left = number(object, "seconds_left");
  if (const auto warnings = object.find("warnings"); warnings != object.end() && warnings->is_array()) {
    for (const json& warning : *warnings) {
      if (warning.is_string()) progress.warnings.push_back(warning.get<std::string>());
    }
  }
  return progress;
}

std::string live_line(const RunProgress& progress, const creep::Experiment& experiment, int width,
                      bool unicode) {
  const Way way = way_of(progress, experiment);
  std::string line = progress.stage;
  if (progress.dynamic_stage > 0) line += text(" %lld", static_cast<long long>(progress.dynamic_stage));
  std::vector<std::string> pieces;  // the most important first
  const std::string from = way.from.empty() ? "" : way.from + " ";
  const std::string to = way.to.empty() ? "" : " " + way.to;
  pieces.push_back(from + bar(way.fraction, width >= 100 ? 16 : 8, unicode) + to);
  if (progress.axial_strain) pieces.push_back(text("strain %.3g %%", 100.0 * *progress.axial_strain));
  if (progress.grading_index) pieces.push_back(text("I_G %.4f", *progress.grading_index));
  if (progress.broken_total) pieces.push_back(text("broken %.0f", *progress.broken_total));
  pieces.push_back(text("%.2g p-steps/s", progress.particle_steps_per_second));
  if (progress.seconds_left) pieces.push_back(short_duration(*progress.seconds_left) + " left");
  for (const std::string& piece : pieces) {
    if (columns_of(line) + 2 + columns_of(piece) <= width) line += "  " + piece;
  }
  return line;
}

std::string plain_line(const RunProgress& progress, const creep::Experiment& experiment) {
  const Way way = way_of(progress, experiment);
  std::string line = progress.stage;
  const creep::Stage* stage = stage_of(progress, experiment);
  if (stage != nullptr && creep::duration_of(*stage)) {
    line += text(", dynamic stage %lld, creep time ", static_cast<long long>(progress.dynamic_stage)) +
            way.from + " of " + way.to;
  } else if (!way.to.empty()) {
    line += way.from.empty() ? ", to " + way.to : ", axial stress " + way.from + " of " + way.to;
  }
  if (progress.axial_strain) line += text(", strain %.3g %%", 100.0 * *progress.axial_strain);
  if (progress.void_ratio) line += text(", e %.4f", *progress.void_ratio);
  if (progress.grading_index) line += text(", I_G %.4f", *progress.grading_index);
  if (progress.broken_total) line += text(", broken %.0f", *progress.broken_total);
  line += text(", %.2e particle-steps/s", progress.particle_steps_per_second);
  if (progress.seconds_left) line += ", " + short_duration(*progress.seconds_left) + " left";
  return line;
}

std::string short_duration(double seconds) {
  if (seconds < 120.0) return text("%.3g s", seconds);
  if (seconds < 7200.0) return text("%.0f min", seconds / 60.0);
  if (seconds < 172800.0) return text("%.1f h", seconds / 3600.0);
  return text("%.1f d", seconds / 86400.0);
}

}  // namespace creepctl
