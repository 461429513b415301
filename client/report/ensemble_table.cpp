#include "client/report/ensemble_table.h"

#include <cmath>

#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_replace.h"
#include "client/terminal/table.h"

namespace creepctl {
namespace {

using nlohmann::ordered_json;

constexpr double kPercent = 100.0;

/// Says over how many runs where not all have a value.
std::string with_count(std::string text, const EnsembleFigures::Mean& mean, const Ensemble& ensemble) {
  if (mean && mean->count != ensemble.runs.size()) absl::StrAppend(&text, "; n = ", mean->count);
  return text;
}

std::string rate_text(const Ensemble& ensemble, const EnsembleFigures& figures) {
  std::string text =
      with_count(geometric_mean_text(figures.ln_rate_10_min), figures.ln_rate_10_min, ensemble);
  if (figures.extrapolated > 0) absl::StrAppend(&text, "; extrapolated: ", figures.extrapolated);
  return text;
}

std::string failure_text(const Ensemble& ensemble, const EnsembleFigures& figures) {
  if (!figures.ln_time_to_failure) return ensemble.runs.empty() ? "–" : "none failed";
  const std::string text = geometric_mean_text(figures.ln_time_to_failure);
  return absl::StrCat(text, "; ", figures.ln_time_to_failure->count, " of ", ensemble.runs.size(), " failed");
}

ordered_json to_json(const EnsembleFigures::Mean& mean, bool of_logarithms) {
  if (!mean) return nullptr;
  const auto back = [&](double value) { return of_logarithms ? std::exp(value) : value; };
  ordered_json value = {{"mean", back(mean->mean)}, {"low", nullptr}, {"high", nullptr}, {"n", mean->count}};
  if (mean->half_width) {
    value["low"] = back(mean->low());
    value["high"] = back(mean->high());
  }
  return value;
}

}  // namespace

std::vector<std::string> ensemble_head() {
  return {"jobs", "n",           "e before creep", "creep strain (%)",    "rate at 10 min (%/min)",
          "m",    "I_{G}",       "ageing jumps",   "time to failure (s)", "paper: q/q_{max}",
          "m",    "rate (%/min)"};
}

std::vector<std::string> ensemble_row(const Ensemble& ensemble) {
  const EnsembleFigures figures = ensemble_figures(ensemble);
  const auto plain = [&](const EnsembleFigures::Mean& mean, double factor = 1.0) {
    return with_count(mean_text(mean, factor), mean, ensemble);
  };
  std::vector<std::string> row = {ensemble.label,
                                  absl::StrCat(ensemble.runs.size()),
                                  plain(figures.void_ratio_before),
                                  plain(figures.creep_strain, kPercent),
                                  rate_text(ensemble, figures),
                                  plain(figures.m),
                                  plain(figures.grading_index),
                                  plain(figures.stages),
                                  failure_text(ensemble, figures)};
  if (const auto& paper = figures.paper) {
    for (const double value : {paper->stress_ratio, paper->m, paper->rate_10_min})
      row.push_back(absl::StrFormat("%.4g", value));
  } else {
    row.insert(row.end(), 3, "–");
  }
  return row;
}

std::vector<std::vector<std::string>> ensemble_rows(const std::vector<Ensemble>& ensembles) {
  std::vector<std::vector<std::string>> rows;
  bool compression = false, creep = false;
  for (const Ensemble& ensemble : ensembles) {
    rows.push_back(ensemble_row(ensemble));
    if (ensemble.runs.empty()) continue;
    const PaperScene scene = paper_scene(ensemble.runs.front().results);
    compression = compression || scene.compression;
    creep = creep || scene.creep;
  }
  if (!compression) return rows;
  std::vector<std::string> paper(ensemble_head().size(), "–");
  paper[0] = "paper: oedometer, 21.7 MPa, 2 d";
  paper[2] = absl::StrFormat("%.3f", kPaperVoidRatio);
  if (creep) paper[7] = absl::StrFormat("%.0f", kPaperDynamicStages);
  rows.push_back(std::move(paper));
  return rows;
}

std::string ensemble_table_text(const std::vector<Ensemble>& ensembles, int width) {
  std::vector<Table::Column> columns;
  for (const std::string& title : ensemble_head()) {
    const std::string plain = absl::StrReplaceAll(title, {{"_{", "_"}, {"}", ""}});
    columns.push_back({absl::AsciiStrToUpper(plain), columns.empty() ? Align::kLeft : Align::kRight});
  }
  Table table(std::move(columns));
  for (const auto& row : ensemble_rows(ensembles)) table.add(row);
  return table.text(width);
}

ordered_json paper_json(const std::optional<TriaxialCreepTest>& test) {
  if (!test) return nullptr;
  return {{"stress_ratio", test->stress_ratio},
          {"singh_mitchell_m", test->m},
          {"rate_10_min_percent_per_min", test->rate_10_min}};
}

ordered_json ensembles_json(const std::vector<Ensemble>& ensembles) {
  ordered_json list = ordered_json::array();
  for (const Ensemble& ensemble : ensembles) {
    const EnsembleFigures figures = ensemble_figures(ensemble);
    ordered_json directories = ordered_json::array();
    for (const ComparedJob& run : ensemble.runs) directories.push_back(run.results.directory.string());
    ordered_json value = {{"jobs", ensemble.label},
                          {"directories", std::move(directories)},
                          {"confidence", creep::kConfidence},
                          {"void_ratio_before_creep", to_json(figures.void_ratio_before, false)},
                          {"creep_strain", to_json(figures.creep_strain, false)},
                          {"rate_10_min_percent_per_min", to_json(figures.ln_rate_10_min, true)},
                          {"singh_mitchell_m", to_json(figures.m, false)},
                          {"grading_index", to_json(figures.grading_index, false)},
                          {"ageing_jumps", to_json(figures.stages, false)},
                          {"time_to_failure_s", to_json(figures.ln_time_to_failure, true)},
                          {"paper", paper_json(figures.paper)}};
    list.push_back(std::move(value));
  }
  return list;
}

}  // namespace creepctl
