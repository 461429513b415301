#include "client/report/ensemble_charts.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>
#include <limits>

#include "absl/strings/str_cat.h"
#include "client/report/chart_parts.h"
#include "client/results/mean_curve.h"

namespace creepctl {
namespace {

constexpr double kPercent = 100.0;
constexpr double kPercentPerMinute = 6000.0;  // of a rate in 1/s
constexpr double kFarApart = 20.0;            // ratio of strains

/// What one chart shows of a run.
using CurveOf = std::function<Curve(const ComparedJob&)>;

Curve strain_curve(const ComparedJob& run) {
  Curve curve{run.hold->curve.creep_time, {}};
  for (const double strain : run.hold->curve.axial_strain) curve.y.push_back(kPercent * strain);
  return curve;
}

Curve rate_curve(const ComparedJob& run) {
  Curve curve;
  for (const creep::StrainRate& rate : run.hold->analysis.rates) {
    curve.x.push_back(rate.creep_time);
    curve.y.push_back(kPercentPerMinute * rate.rate);
  }
  return curve;
}

Curve grading_index_curve(const ComparedJob& run) {
  Curve curve{run.hold->curve.creep_time, {}};
  for (const std::size_t row : run.hold->stage_rows)
    curve.y.push_back(run.results.stages.at(row, "grading_index_end"));
  return curve;
}

Series band_of(const MeanCurve& mean) {
  Series band{"", mean.x, mean.high};
  band.shape = Shape::kBand;
  band.x.insert(band.x.end(), mean.x.rbegin(), mean.x.rend());
  band.y.insert(band.y.end(), mean.low.rbegin(), mean.low.rend());
  return band;
}

bool is_band(const Series& series) { return series.shape == Shape::kBand; }

/// Intervals of few seeds reach far: the axis leaves them a share of the room that the curves take on either
/// side, and cuts the rest.
void keep_curves_large(Chart& chart, bool (*is_interval)(const Series&)) {
  constexpr double kRoom = 0.15;
  const bool log = chart.y.scale == Scale::kLog;
  const auto place = [&](double value) { return log ? std::log(value) : value; };
  double low = std::numeric_limits<double>::infinity(), high = -low, lowest = low, highest = high;
  for (const Series& series : chart.series) {
    for (const double value : series.y) {
      if (!drawable(chart.y.scale, value)) continue;
      lowest = std::min(lowest, place(value));
      highest = std::max(highest, place(value));
      if (is_interval(series)) continue;
      low = std::min(low, place(value));
      high = std::max(high, place(value));
    }
  }
  const double room = kRoom * (high - low);
  if (!(room > 0.0) || (lowest >= low - room && highest <= high + room)) return;
  const AxisRange fit = axis_range(
      chart.y.scale, {log ? std::exp(std::max(lowest, low - room)) : std::max(lowest, low - room),
                      log ? std::exp(std::min(highest, high + room)) : std::min(highest, high + room)});
  chart.y.low = fit.low;
  chart.y.high = fit.high;
}

Chart time_chart(const std::vector<Ensemble>& ensembles, const CurveOf& curve_of, MeanOf what) {
  Chart chart;
  chart.x = creep_time_axis();
  chart.landmarks = creep_time_landmarks();
  std::vector<Series> bands, lines;
  for (std::size_t number = 0; number < ensembles.size(); ++number) {
    std::vector<Curve> curves;
    for (const ComparedJob& run : ensembles[number].runs) {
      if (run.hold && !run.hold->stage_rows.empty()) curves.push_back(curve_of(run));
    }
    const auto mean = mean_curve(curves, what);
    if (!mean) continue;
    for (std::size_t i = 0; ensembles.size() == 1 && mean->count > 1 && i < curves.size(); ++i) {
      Series run{i == 0 ? "single runs" : "", curves[i].x, curves[i].y};
      run.hue = Hue::kGrey;
      run.line_width = 0.9;
      chart.series.push_back(std::move(run));
    }
    Series line{absl::StrCat(ensembles[number].label, ", n = ", mean->count), mean->x, mean->mean};
    line.line_width = 2.2;
    tell_apart(line, number);
    if (!mean->low.empty()) {
      Series band = band_of(*mean);
      band.hue = line.hue;
      bands.push_back(std::move(band));
    }
    lines.push_back(std::move(line));
  }
  if (!bands.empty()) {
    chart.notes.push_back("tinted: 95 % interval of the mean");
  } else if (!lines.empty()) {
    chart.notes.push_back("one run each: no uncertainty is known");
  }
  chart.series.insert(chart.series.begin(), bands.begin(), bands.end());
  chart.series.insert(chart.series.end(), lines.begin(), lines.end());
  return chart;
}

bool have_means(const std::vector<Ensemble>& ensembles) {
  return std::any_of(ensembles.begin(), ensembles.end(),
                     [](const Ensemble& ensemble) { return ensemble.runs.size() > 1; });
}

std::string title_of(const std::string& plain, const std::vector<Ensemble>& ensembles) {
  return have_means(ensembles) ? absl::StrCat(plain, ", mean over seeds") : plain;
}

/// Whether the mean creep strains at the end differ so much that a linear axis would hide the small ones.
bool strains_differ_by_far(const std::vector<Ensemble>& ensembles) {
  double least = std::numeric_limits<double>::infinity(), most = 0.0;
  for (const Ensemble& ensemble : ensembles) {
    const auto strain = ensemble_figures(ensemble).creep_strain;
    if (!strain || !(strain->mean > 0.0)) continue;
    least = std::min(least, strain->mean);
    most = std::max(most, strain->mean);
  }
  return most > kFarApart * least;
}

const char* const kCaption =
    "Mean over the seeds, where all runs of an ensemble have values, with Student's 95 % interval of the "
    "mean.";

NamedChart strain_chart(const std::vector<Ensemble>& ensembles,
                        const std::vector<LaboratoryCurve>& laboratory) {
  const bool log = strains_differ_by_far(ensembles);
  Chart chart = time_chart(ensembles, strain_curve, log ? MeanOf::kLogarithms : MeanOf::kValues);
  chart.title = title_of("Creep: axial strain – log time", ensembles);
  chart.y = {"axial creep strain ε_{a} (%)", log ? Scale::kLog : Scale::kLinear, {}, {}, false};
  add_laboratory(chart, laboratory);
  keep_curves_large(chart, is_band);
  return {"mean_creep_strain_log_time",
          absl::StrCat("Strain since the hold began. ", kCaption, log ? " Averaged as logarithms." : ""),
          chart};
}

NamedChart rate_chart(const std::vector<Ensemble>& ensembles) {
  Chart chart = time_chart(ensembles, rate_curve, MeanOf::kLogarithms);
  chart.title = title_of("Creep rate: log axial strain rate – log time", ensembles);
  chart.y = {"axial strain rate (%/min)", Scale::kLog, {}, {}, false};
  keep_curves_large(chart, is_band);
  return {"mean_creep_rate_log_time",
          absl::StrCat("Rates between the ends of neighbouring dynamic stages. ", kCaption,
                       " Rates are averaged as logarithms; rates that are not positive are left out."),
          chart};
}

NamedChart grading_index_chart(const std::vector<Ensemble>& ensembles) {
  Chart chart = time_chart(ensembles, grading_index_curve, MeanOf::kValues);
  chart.title = title_of("Grading index – log time", ensembles);
  chart.y = {"grading index I_{G} (–)", Scale::kLinear, {}, {}, false};
  keep_curves_large(chart, is_band);
  return {"mean_grading_index_log_time", kCaption, chart};
}

/// Of ensembles that are trials of the paper's triaxial creep tests.
NamedChart paper_rate_chart(const std::vector<Ensemble>& ensembles) {
  Chart chart;
  chart.title = "Axial strain rate at 10 min – stress ratio";
  chart.x = {"q / q_{max} (–)", Scale::kLinear, 0.0, 1.0, false};
  chart.y = {"axial strain rate at 10 min (%/min)", Scale::kLog, {}, {}, false};
  Series paper{"Lei et al., Table 2", {}, {}};
  for (const TriaxialCreepTest& test : kPaperTriaxialCreep) {
    paper.x.push_back(test.stress_ratio);
    paper.y.push_back(test.rate_10_min);
  }
  paper.hue = Hue::kBlack;
  paper.marker = Marker::kStar;
  paper.line_width = 1.0;
  Series means{"mean over seeds", {}, {}};
  means.hue = Hue::kVermilion;
  means.marker = Marker::kCircle;
  means.stroke = false;
  bool has_intervals = false;
  for (const Ensemble& ensemble : ensembles) {
    const EnsembleFigures figures = ensemble_figures(ensemble);
    if (!figures.paper || !figures.ln_rate_10_min) continue;
    const creep::EnsembleMean& rate = *figures.ln_rate_10_min;
    means.x.push_back(figures.paper->stress_ratio);
    means.y.push_back(std::exp(rate.mean));
    means.point_labels.push_back(absl::StrCat("n = ", rate.count));
    if (!rate.half_width) continue;
    Series bar{"", {means.x.back(), means.x.back()}, {std::exp(rate.low()), std::exp(rate.high())}};
    bar.hue = Hue::kVermilion;
    bar.line_width = 1.3;
    chart.series.push_back(std::move(bar));
    has_intervals = true;
  }
  if (means.x.size() < 2) return {};
  // One number of seeds is said once.
  const bool alike =
      std::all_of(means.point_labels.begin(), means.point_labels.end(),
                  [&](const std::string& label) { return label == means.point_labels.front(); });
  if (alike) {
    absl::StrAppend(&means.label, ", ", means.point_labels.front());
    means.point_labels.clear();
  }
  if (has_intervals) chart.notes.push_back("bars: 95 % interval of the mean");
  chart.series.push_back(std::move(paper));
  chart.series.push_back(std::move(means));
  keep_curves_large(chart, [](const Series& series) { return series.label.empty(); });
  return {
      "rate_10_min_stress_ratio",
      "Of the Singh-Mitchell fit over primary creep, averaged as logarithms; beyond the fit's window it is "
      "extrapolated.",
      chart};
}

}  // namespace

std::vector<NamedChart> ensemble_charts(const std::vector<Ensemble>& ensembles,
                                        const std::vector<LaboratoryCurve>& laboratory) {
  std::vector<NamedChart> charts;
  for (NamedChart& chart : std::vector{strain_chart(ensembles, laboratory), rate_chart(ensembles),
                                       grading_index_chart(ensembles), paper_rate_chart(ensembles)}) {
    if (!chart.chart.series.empty()) charts.push_back(std::move(chart));
  }
  return charts;
}

}  // namespace creepctl
