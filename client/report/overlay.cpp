#include "client/report/overlay.h"

#include <algorithm>
#include <cmath>

#include "absl/strings/str_cat.h"
#include "client/report/chart_parts.h"

namespace creepctl {
namespace {

constexpr double kPercent = 100.0;
constexpr double kPercentPerMinute = 6000.0;  // of a rate in 1/s
constexpr double kTenMinutes = 600.0;         // [s]
constexpr double kMegapascal = 1e6;

/// `y_of` gives the value at the i-th dynamic stage of the hold of a job.
template <typename Value>
void add_by_creep_time(Chart& chart, const std::vector<ComparedJob>& jobs, Value y_of) {
  for (std::size_t number = 0; number < jobs.size(); ++number) {
    const ComparedJob& job = jobs[number];
    if (!job.hold || job.hold->stage_rows.empty()) continue;
    Series series{job.label, job.hold->curve.creep_time, {}};
    series.marker = Marker::kCircle;
    tell_apart(series, number);
    for (std::size_t i = 0; i < job.hold->stage_rows.size(); ++i) series.y.push_back(y_of(job, i));
    chart.series.push_back(std::move(series));
  }
}

NamedChart strain_chart(const std::vector<ComparedJob>& jobs,
                        const std::vector<LaboratoryCurve>& laboratory) {
  Chart chart;
  chart.title = "Creep: axial strain – log time";
  chart.x = creep_time_axis();
  chart.y = {"axial creep strain ε_{a} (%)", Scale::kLinear, {}, {}, false};
  chart.landmarks = creep_time_landmarks();
  add_by_creep_time(chart, jobs, [](const ComparedJob& job, std::size_t i) {
    return kPercent * job.hold->curve.axial_strain[i];
  });
  add_laboratory(chart, laboratory);
  return {"compared_creep_strain_log_time", "Strain since the hold began, at the ends of the dynamic stages.",
          chart};
}

NamedChart grading_index_chart(const std::vector<ComparedJob>& jobs) {
  Chart chart;
  chart.title = "Grading index – log time";
  chart.x = creep_time_axis();
  chart.y = {"grading index I_{G} (–)", Scale::kLinear, {}, {}, false};
  chart.landmarks = creep_time_landmarks();
  add_by_creep_time(chart, jobs, [](const ComparedJob& job, std::size_t i) {
    return job.results.stages.at(job.hold->stage_rows[i], "grading_index_end");
  });
  return {"compared_grading_index_log_time", "At the ends of the dynamic stages.", chart};
}

NamedChart void_ratio_chart(const std::vector<ComparedJob>& jobs) {
  Chart chart;
  chart.title = "Compression: void ratio – log axial stress";
  chart.x = {"axial stress σ_{a} (MPa)", Scale::kLog, {}, {}, false};
  chart.y = {"void ratio e (–)", Scale::kLinear, {}, {}, false};
  for (std::size_t number = 0; number < jobs.size(); ++number) {
    Series series{jobs[number].label, {}, {}};
    tell_apart(series, number);
    for (const std::size_t row : loading_and_creep_samples(jobs[number].results)) {
      series.x.push_back(jobs[number].results.samples.at(row, "axial_stress_Pa") / kMegapascal);
      series.y.push_back(jobs[number].results.samples.at(row, "void_ratio"));
    }
    if (!series.x.empty()) chart.series.push_back(std::move(series));
  }
  return {"compared_void_ratio_log_stress", "Fines booked by splits counted as solid.", chart};
}

}  // namespace

absl::StatusOr<std::vector<ComparedJob>> read_compared_jobs(const std::vector<std::string>& directories) {
  std::vector<ComparedJob> jobs;
  for (const std::string& directory : directories) {
    auto results = read_job_results(directory);
    if (!results.ok())
      return absl::Status(results.status().code(), absl::StrCat(directory, ": ", results.status().message()));
    std::optional<Hold> hold = last_hold(*results);
    jobs.push_back({results->name, *std::move(results), std::move(hold)});
  }
  std::vector<std::string> names;
  for (const ComparedJob& job : jobs) names.push_back(job.label);
  for (std::size_t i = 0; i < jobs.size(); ++i) {
    if (std::count(names.begin(), names.end(), names[i]) > 1)
      jobs[i].label = absl::StrCat(names[i], " (", directories[i], ")");
  }
  return jobs;
}

std::vector<NamedChart> overlay_charts(const std::vector<ComparedJob>& jobs,
                                       const std::vector<LaboratoryCurve>& laboratory) {
  std::vector<NamedChart> charts;
  for (NamedChart& chart :
       std::vector{strain_chart(jobs, laboratory), grading_index_chart(jobs), void_ratio_chart(jobs)}) {
    if (!chart.chart.series.empty()) charts.push_back(std::move(chart));
  }
  return charts;
}

ComparedFigures compared_figures(const ComparedJob& job) {
  ComparedFigures figures;
  const auto told = [](double value) { return std::isfinite(value) ? std::optional(value) : std::nullopt; };
  if (!job.hold || job.hold->stage_rows.empty()) return figures;
  const NumberTable& stages = job.results.stages;
  figures.void_ratio_before = told(stages.at(job.hold->stage_rows.front(), "void_ratio_end"));
  figures.creep_strain = told(job.hold->curve.axial_strain.back());
  figures.grading_index = told(stages.at(job.hold->stage_rows.back(), "grading_index_end"));
  if (const auto& fit = job.hold->analysis.primary_fit) {
    figures.m = fit->m;
    figures.rate_10_min = kPercentPerMinute * fit->rate(kTenMinutes);
  }
  figures.paper = paper_triaxial_creep(job.results, *job.hold);
  return figures;
}

}  // namespace creepctl
