#include "client/report/stress_charts.h"

#include <algorithm>
#include <functional>

#include "absl/strings/str_format.h"
#include "core/output/record.h"

namespace creepctl {
namespace {

constexpr double kPercent = 100.0;
constexpr double kMegapascal = 1e6;

bool has_triaxial_stage(const JobResults& results) {
  if (!results.experiment) return false;
  const auto& program = results.experiment->program;
  return std::any_of(program.begin(), program.end(), [](const creep::Stage& stage) {
    return std::holds_alternative<creep::TriaxialStage>(stage);
  });
}

/// A value of every sample over the axial strain: loading and holds apart.
Chart over_axial_strain(const JobResults& results, const std::function<double(std::size_t)>& value) {
  Series loading{"loading", {}, {}};
  Series holding{"holds", {}, {}};
  holding.hue = Hue::kVermilion;
  holding.stroke = false;
  holding.marker = Marker::kCircle;
  for (const std::size_t row : loading_and_creep_samples(results)) {
    const bool in_hold = results.samples.at(row, "phase") >= static_cast<double>(creep::Phase::kDynamicStage);
    Series& series = in_hold ? holding : loading;
    series.x.push_back(kPercent * results.samples.at(row, "axial_strain"));
    series.y.push_back(value(row));
  }
  Chart chart;
  chart.x = {"axial strain ε_{a} (%)", Scale::kLinear, {}, {}, false};
  chart.series = {loading};
  if (!holding.x.empty()) chart.series.push_back(holding);
  return chart;
}

NamedChart deviatoric_chart(const JobResults& results) {
  Chart chart = over_axial_strain(results, [&](std::size_t row) {
    return (results.samples.at(row, "axial_stress_Pa") - results.samples.at(row, "radial_stress_Pa")) /
           kMegapascal;
  });
  chart.title = "Shear: deviatoric stress – axial strain";
  chart.y = {"deviatoric stress q (MPa)", Scale::kLinear, {}, {}, false};
  if (const auto peak = results.figure("peak_deviatoric_stress_Pa"); peak && *peak > 0.0) {
    chart.notes.push_back(absl::StrFormat("largest q of a sample: %.3g MPa", *peak / kMegapascal));
  }
  return {"deviatoric_stress_axial_strain",
          "q = axial less radial stress, from wall forces. Strain since the end of packing.", chart};
}

NamedChart volumetric_chart(const JobResults& results) {
  Chart chart = over_axial_strain(
      results, [&](std::size_t row) { return kPercent * results.samples.at(row, "volumetric_strain"); });
  chart.title = "Shear: volumetric strain – axial strain";
  chart.y = {"volumetric strain ε_{v} (%)", Scale::kLinear, {}, {}, false};
  return {"volumetric_strain_axial_strain",
          "Volume loss over the volume at the end of packing: rising is contraction.", chart};
}

NamedChart relaxation_chart(const JobResults& results, const Hold& hold) {
  Series axial{"axial stress", {}, {}};
  Series radial{"radial stress", {}, {}};
  radial.hue = Hue::kSky;
  radial.dash = Dash::kDashed;
  for (const std::size_t row : hold.sample_rows) {
    const double creep_time = results.samples.at(row, "creep_time_s");
    axial.x.push_back(creep_time);
    axial.y.push_back(results.samples.at(row, "axial_stress_Pa") / kMegapascal);
    radial.x.push_back(creep_time);
    radial.y.push_back(results.samples.at(row, "radial_stress_Pa") / kMegapascal);
  }
  Chart chart;
  chart.title = "Relaxation: stress – log time";
  chart.x = {"time t since the strain is held (s)", Scale::kLog, {}, {}, false};
  chart.y = {"stress (MPa)", Scale::kLinear, {}, {}, false};
  chart.series = {axial, radial};
  return {"relaxation_stress_log_time", "Stress on the walls while the axial strain is held.", chart};
}

}  // namespace

std::vector<NamedChart> stress_charts(const JobResults& results) {
  std::vector<NamedChart> charts;
  if (has_triaxial_stage(results) && !loading_and_creep_samples(results).empty()) {
    charts.push_back(deviatoric_chart(results));
    charts.push_back(volumetric_chart(results));
  }
  if (const auto relaxation = last_relaxation(results))
    charts.push_back(relaxation_chart(results, *relaxation));
  return charts;
}

}  // namespace creepctl
