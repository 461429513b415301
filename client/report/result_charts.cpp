#include "client/report/result_charts.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "client/report/stress_charts.h"
#include "client/results/broken_fraction.h"

namespace creepctl {
namespace {

constexpr double kPercent = 100.0;
constexpr double kPercentPerMinute = 6000.0;  // of a rate in 1/s
constexpr double kTenMinutes = 600.0;         // [s]
constexpr double kMegapascal = 1e6;
constexpr double kMillimetre = 1e-3;

std::vector<Landmark> creep_time_landmarks() {
  return {{1e-3, "1 ms"},  {1.0, "1 s"},     {60.0, "1 min"},
          {3600.0, "1 h"}, {86400.0, "1 d"}, {2592000.0, "30 d"}};
}

Axis creep_time_axis() { return {"creep time t (s)", Scale::kLog, {}, {}, false}; }

/// From the decade in which the initial dynamic stage ended: what is before is its own settling.
Axis creep_time_axis(const Hold& hold) {
  Axis axis = creep_time_axis();
  const std::vector<double>& ends = hold.curve.creep_time;
  if (!ends.empty() && ends.front() > 0.0) axis.low = std::pow(10.0, std::floor(std::log10(ends.front())));
  return axis;
}

std::string power_text(double value) {
  if (value == 0.0 || !std::isfinite(value)) return "0";
  const int exponent = static_cast<int>(std::floor(std::log10(std::fabs(value))));
  if (exponent == 3) return absl::StrFormat("%.0f", value);
  if (exponent >= -3 && exponent < 3) return absl::StrFormat("%.3g", value);
  return absl::StrFormat("%.2f×10^{%s}", value / std::pow(10.0, exponent),
                         exponent < 0 ? absl::StrCat("−", -exponent) : absl::StrCat(exponent));
}

std::optional<NamedChart> void_ratio_chart(const JobResults& results, const std::optional<Hold>& hold) {
  Series loading{"loading", {}, {}};
  Series particles{"loading, fines not counted as solid", {}, {}};
  particles.hue = Hue::kSky;
  particles.dash = Dash::kDashed;
  particles.line_width = 1.3;
  Series creeping{"creep", {}, {}};
  creeping.hue = Hue::kVermilion;
  creeping.line_width = 2.6;
  for (const std::size_t row : loading_and_creep_samples(results)) {
    const bool in_hold = hold && results.samples.at(row, "phase") >= 2.0;
    const double stress = results.samples.at(row, "axial_stress_Pa") / kMegapascal;
    Series& series = in_hold ? creeping : loading;
    series.x.push_back(stress);
    series.y.push_back(results.samples.at(row, "void_ratio"));
    if (in_hold) continue;
    particles.x.push_back(stress);
    particles.y.push_back(results.samples.at(row, "void_ratio_particles"));
  }
  if (loading.x.empty() && creeping.x.empty()) return std::nullopt;
  Chart chart;
  chart.title = "Compression: void ratio – log axial stress";
  chart.x = {"axial stress σ_{a} (MPa)", Scale::kLog, {}, {}, false};
  chart.y = {"void ratio e (–)", Scale::kLinear, {}, {}, false};
  chart.series = {particles, loading};
  if (!creeping.x.empty()) chart.series.push_back(creeping);
  std::string caption =
      "Void ratio with the fines booked by splits counted as solid (solid line) and not (dashed).";
  if (paper_scene(results).compression) {
    Series paper{"Lei et al.: e = 0.584 at 21.7 MPa, before creep",
                 {kPaperAxialStress / kMegapascal},
                 {kPaperVoidRatio}};
    paper.hue = Hue::kBlack;
    paper.stroke = false;
    paper.marker = Marker::kStar;
    chart.series.push_back(paper);
    absl::StrAppend(&caption, " The star is the paper's state before creep.");
  }
  return NamedChart{"void_ratio_log_stress", caption, chart};
}

std::optional<NamedChart> strain_chart(const JobResults& results, const Hold& hold) {
  Series state{"every sample", {}, {}};
  state.hue = Hue::kGrey;
  state.line_width = 1.0;
  for (const std::size_t row : hold.sample_rows) {
    state.x.push_back(results.samples.at(row, "creep_time_s"));
    state.y.push_back(kPercent * (results.samples.at(row, "axial_strain") - hold.strain_before));
  }
  Series ends{"ends of the dynamic stages", {}, {}};
  ends.hue = Hue::kVermilion;
  ends.marker = Marker::kCircle;
  for (std::size_t i = 0; i < hold.stage_rows.size(); ++i) {
    ends.x.push_back(hold.curve.creep_time[i]);
    ends.y.push_back(kPercent * hold.curve.axial_strain[i]);
    ends.point_labels.push_back(
        absl::StrFormat("%.0f", results.stages.at(hold.stage_rows[i], "dynamic_stage")));
  }
  if (state.x.empty() && ends.x.empty()) return std::nullopt;
  Chart chart;
  chart.title = "Creep: axial strain – log time";
  chart.x = creep_time_axis(hold);
  chart.y = {"axial creep strain ε_{a} (%)", Scale::kLinear, {}, {}, false};
  chart.landmarks = creep_time_landmarks();
  chart.series = {state, ends};
  if (const auto& fit = hold.analysis.log_time_fit; fit && hold.curve.creep_time.back() > 0.0) {
    Series line{"least squares in log time", {}, {}};
    line.hue = Hue::kBlue;
    line.dash = Dash::kDashed;
    line.line_width = 1.3;
    const auto first = std::find_if(hold.curve.creep_time.begin(), hold.curve.creep_time.end(),
                                    [](double creep_time) { return creep_time > 0.0; });
    for (const double creep_time : {*first, hold.curve.creep_time.back()}) {
      line.x.push_back(creep_time);
      line.y.push_back(kPercent * (fit->strain_at_1_s + fit->strain_per_decade * std::log10(creep_time)));
    }
    chart.series.push_back(line);
    chart.notes.push_back(
        absl::StrFormat("%.3f %% per decade, n = %d%s", kPercent * fit->strain_per_decade, fit->points,
                        fit->r_squared ? absl::StrFormat(", R² = %.3f", *fit->r_squared) : ""));
  }
  return NamedChart{
      "creep_strain_log_time",
      "Strain since the hold began. Numbers count the dynamic stages from 0, the initial one; between them "
      "the specimen ages off-DEM and the strain stands still.",
      chart};
}

void add_fit(Chart& chart, const creep::SinghMitchellFit& fit) {
  const auto line = [&](double begin, double end, Dash dash, const std::string& label) {
    Series series{
        label, {begin, end}, {kPercentPerMinute * fit.rate(begin), kPercentPerMinute * fit.rate(end)}};
    series.hue = Hue::kBlue;
    series.dash = dash;
    chart.series.push_back(series);
  };
  line(fit.window_begin, fit.window_end, Dash::kSolid,
       absl::StrFormat("rate ∝ t^{–m}, m = %.2f ± %.1g", fit.m, fit.m_standard_error));
  if (kTenMinutes > fit.window_end) line(fit.window_end, kTenMinutes, Dash::kDotted, "extrapolated");
  if (kTenMinutes < fit.window_begin) line(kTenMinutes, fit.window_begin, Dash::kDotted, "extrapolated");
  Series at_ten{"fit at 10 min: " + power_text(kPercentPerMinute * fit.rate(kTenMinutes)) + " %/min",
                {kTenMinutes},
                {kPercentPerMinute * fit.rate(kTenMinutes)}};
  at_ten.hue = Hue::kBlack;
  at_ten.stroke = false;
  at_ten.marker = Marker::kDiamond;
  chart.series.push_back(at_ten);
  chart.notes.push_back(
      absl::StrCat("window ", power_text(fit.window_begin), " to ", power_text(fit.window_end), " s"));
  chart.notes.push_back(absl::StrFormat("n = %d%s", fit.points,
                                        fit.r_squared ? absl::StrFormat(", R² = %.3f", *fit.r_squared) : ""));
  if (fit.omitted > 0) chart.notes.push_back(absl::StrFormat("%d rates ≤ 0 left out", fit.omitted));
}

std::optional<NamedChart> rate_chart(const Hold& hold) {
  if (hold.analysis.rates.empty()) return std::nullopt;
  Series rates{"between ends of dynamic stages", {}, {}};
  rates.hue = Hue::kVermilion;
  rates.marker = Marker::kCircle;
  rates.stroke = false;
  for (const creep::StrainRate& point : hold.analysis.rates) {
    rates.x.push_back(point.creep_time);
    rates.y.push_back(kPercentPerMinute * point.rate);
  }
  Chart chart;
  chart.title = "Creep rate: log axial strain rate – log time";
  chart.x = creep_time_axis();
  chart.y = {"axial strain rate (%/min)", Scale::kLog, {}, {}, false};
  chart.landmarks = creep_time_landmarks();
  chart.series = {rates};
  std::string caption =
      "Rate = (dε/d ln t)/t between ends of dynamic stages, at least a factor of 2 apart in time, at the "
      "geometric middle of the interval. ";
  if (hold.analysis.primary_fit) {
    add_fit(chart, *hold.analysis.primary_fit);
    absl::StrAppend(&caption, "Singh-Mitchell line by least squares over primary creep only.");
  } else {
    absl::StrAppend(&caption, "Too few rates of primary creep for a Singh-Mitchell line (3 are needed).");
  }
  if (const auto& onset = hold.analysis.tertiary; onset) {
    Series least{absl::StrCat("least smoothed rate at ", duration_text(onset->creep_time)),
                 {onset->earliest, onset->latest},
                 {kPercentPerMinute * onset->minimum_rate, kPercentPerMinute * onset->minimum_rate}};
    least.hue = Hue::kPurple;
    least.line_width = 3.0;
    chart.series.push_back(least);
    absl::StrAppend(&caption, " The bar spans the range of the onset of tertiary creep.");
  }
  return NamedChart{"creep_rate_log_time", caption, chart};
}

/// The curve of gsd.csv numbered `number`.
Series grading_series(const NumberTable& grading, double number, std::string label, Hue hue) {
  Series series{std::move(label), {}, {}};
  series.hue = hue;
  for (std::size_t row = 0; row < grading.rows(); ++row) {
    if (grading.at(row, "curve") != number) continue;
    series.x.push_back(grading.at(row, "diameter_m") / kMillimetre);
    series.y.push_back(kPercent * grading.at(row, "passing"));
  }
  return series;
}

Series fractal_limit(const creep::Material& material) {
  Series series{absl::StrFormat("fractal limit, β = %.3g, d_{max} = %.3g mm", material.fractal_dimension,
                                material.grading_index_max_diameter / kMillimetre),
                {},
                {}};
  series.hue = Hue::kBlack;
  series.dash = Dash::kDashed;
  series.line_width = 1.4;
  const double power = 3.0 - material.fractal_dimension;
  const double low = material.grading_index_min_diameter;
  const double high = material.grading_index_max_diameter;
  constexpr int kPieces = 80;
  for (int i = 0; i <= kPieces; ++i) {
    const double diameter = low * std::pow(high / low, static_cast<double>(i) / kPieces);
    series.x.push_back(diameter / kMillimetre);
    series.y.push_back(kPercent * (std::pow(diameter, power) - std::pow(low, power)) /
                       (std::pow(high, power) - std::pow(low, power)));
  }
  return series;
}

std::optional<NamedChart> grading_chart(const JobResults& results) {
  const std::vector<double>& curves = results.grading.column("curve");
  if (curves.empty()) return std::nullopt;
  const double last = curves.back();
  double before_creep = curves.front();
  for (std::size_t row = 0; row < results.grading.rows(); ++row) {
    if (results.grading.at(row, "creep_time_s") <= 0.0) before_creep = curves[row];
  }
  Chart chart;
  chart.title = "Grading by mass";
  chart.x = {"particle diameter d (mm)", Scale::kLog, {}, {}, false};
  chart.y = {"finer by mass (%)", Scale::kLinear, 0.0, 100.0, false};
  chart.series.push_back(
      fractal_limit(results.experiment ? results.experiment->material : creep::Material()));
  chart.series.push_back(grading_series(results.grading, curves.front(), "initial", Hue::kBlue));
  if (before_creep != curves.front() && before_creep != last) {
    chart.series.push_back(grading_series(results.grading, before_creep, "start of creep", Hue::kGreen));
  }
  if (last != curves.front()) {
    double creep_time = 0.0;
    for (std::size_t row = 0; row < results.grading.rows(); ++row)
      creep_time = results.grading.at(row, "creep_time_s");
    const std::string label =
        creep_time > 0.0 ? "after " + duration_text(creep_time) + " of creep" : "end of loading";
    chart.series.push_back(grading_series(results.grading, last, label, Hue::kVermilion));
  }
  return NamedChart{
      "grading",
      "Fines booked by splits are included as mass finer. I_G compares the area under the current curve "
      "with that under the fractal limit.",
      chart};
}

std::optional<NamedChart> grading_index_chart(const JobResults& results, const Hold& hold) {
  Series state{"every sample", {}, {}};
  state.hue = Hue::kGrey;
  state.line_width = 1.0;
  for (const std::size_t row : hold.sample_rows) {
    state.x.push_back(results.samples.at(row, "creep_time_s"));
    state.y.push_back(results.samples.at(row, "grading_index"));
  }
  Series ends{"ends of the dynamic stages", {}, {}};
  ends.hue = Hue::kGreen;
  ends.marker = Marker::kCircle;
  for (const std::size_t row : hold.stage_rows) {
    ends.x.push_back(results.stages.at(row, "creep_time_end_s"));
    ends.y.push_back(results.stages.at(row, "grading_index_end"));
  }
  if (state.x.empty() && ends.x.empty()) return std::nullopt;
  Chart chart;
  chart.title = "Grading index – log time";
  chart.x = creep_time_axis(hold);
  chart.y = {"grading index I_{G} (–)", Scale::kLinear, {}, {}, false};
  chart.landmarks = creep_time_landmarks();
  chart.series = {state, ends};
  return NamedChart{"grading_index_log_time", "0 for no area under the curve, 1 at the fractal limit.",
                    chart};
}

std::optional<NamedChart> ripple_chart(const JobResults& results, const Hold& hold) {
  Series ripple{"", {}, {}};
  ripple.shape = Shape::kBars;
  for (const std::size_t row : hold.stage_rows) {
    ripple.x.push_back(results.stages.at(row, "dynamic_stage"));
    ripple.y.push_back(kPercent * results.stages.at(row, "ripple"));
  }
  if (ripple.x.empty()) return std::nullopt;
  Chart chart;
  chart.title = "Axial stress ripple by dynamic stage";
  chart.x = {"dynamic stage (0 = initial)", Scale::kLinear, {}, {}, true};
  chart.y = {"largest |σ_{a}/target – 1| (%)", Scale::kLinear, 0.0, {}, false};
  chart.series = {ripple};
  chart.levels = {{kPercent * kPaperRipple, "Lei et al. stayed below 4 %"}};
  return NamedChart{
      "stress_ripple",
      "Largest deviation of a controlled wall stress from its target in each dynamic stage of the hold.",
      chart};
}

std::optional<NamedChart> broken_fraction_chart(const JobResults& results) {
  const std::vector<BrokenFraction> classes = broken_fractions(results);
  if (classes.empty()) return std::nullopt;
  constexpr Hue kHues[] = {Hue::kSky, Hue::kGreen, Hue::kOrange, Hue::kVermilion};
  constexpr Marker kMarkers[] = {Marker::kCircle, Marker::kSquare, Marker::kDiamond, Marker::kCircle};
  Chart chart;
  chart.title = "Broken fraction by size class – log time";
  chart.x = creep_time_axis();
  chart.y = {"broken so far / present number (%)", Scale::kLinear, {}, {}, false};
  chart.landmarks = creep_time_landmarks();
  for (std::size_t i = 0; i < classes.size(); ++i) {
    Series series{
        absl::StrFormat("%.3f–%.3f mm", classes[i].smallest / kMillimetre, classes[i].largest / kMillimetre),
        classes[i].creep_time,
        {}};
    for (const double fraction : classes[i].fraction) series.y.push_back(kPercent * fraction);
    series.hue = kHues[i % std::size(kHues)];
    series.marker = kMarkers[i % std::size(kMarkers)];
    chart.series.push_back(series);
  }
  return NamedChart{
      "broken_fraction_log_time",
      "Particles of the class broken since the start of the test, loading included, over those of the class "
      "present now (numbers from the grading curves).",
      chart};
}

}  // namespace

std::vector<NamedChart> result_charts(const JobResults& results, const std::optional<Hold>& hold) {
  std::vector<NamedChart> charts;
  const auto add = [&](std::optional<NamedChart> chart) {
    if (chart) charts.push_back(*std::move(chart));
  };
  add(void_ratio_chart(results, hold));
  for (NamedChart& chart : stress_charts(results)) charts.push_back(std::move(chart));
  if (hold) {
    add(strain_chart(results, *hold));
    add(rate_chart(*hold));
  }
  add(grading_chart(results));
  if (hold) {
    add(grading_index_chart(results, *hold));
    add(ripple_chart(results, *hold));
    add(broken_fraction_chart(results));
  }
  return charts;
}

}  // namespace creepctl
