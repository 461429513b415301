#include "client/report/ensemble_page.h"

#include <algorithm>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "client/report/ensemble_charts.h"
#include "client/report/ensemble_table.h"
#include "client/report/html.h"
#include "core/experiment/numerics_text.h"
#include "core/experiment/stage_text.h"

namespace creepctl {
namespace {

using Rows = std::vector<std::vector<std::string>>;

std::string note_section(const std::vector<Ensemble>& ensembles) {
  const bool single = std::all_of(ensembles.begin(), ensembles.end(),
                                  [](const Ensemble& one) { return one.runs.size() < 2; });
  return absl::StrCat(single ? "<p class=\"warning\">" : "<p>", html_escape(confidence_note(ensembles)),
                      "</p>\n");
}

std::string figures_section(const std::vector<Ensemble>& ensembles) {
  return absl::StrCat(
      "<h2>Figures</h2>\n", html_table(ensemble_head(), ensemble_rows(ensembles), true),
      "<p class=\"muted\">e when the hold began; strain and I_G at its end; m and rate of the Singh-Mitchell "
      "fit over primary creep of each run. The last columns: Lei, Arroyo, Ciantia &amp; Zhang, Table 2, "
      "where all "
      "runs are trials of one of its tests.</p>\n");
}

std::string charts_section(const std::vector<Ensemble>& ensembles) {
  std::string out = "<h2>Plots</h2>\n";
  const auto charts = ensemble_charts(ensembles, {});
  for (std::size_t i = 0; i < charts.size(); ++i) {
    absl::StrAppend(&out,
                    html_figure(draw_svg(charts[i].chart, absl::StrCat("p", i, "-")), charts[i].caption));
  }
  if (charts.empty()) out += "<p>None: no job has ended with a creep stage.</p>\n";
  return out;
}

/// What was asked of the jobs of each ensemble; the seeds are in the list of runs.
std::string settings_section(const std::vector<Ensemble>& ensembles) {
  Rows rows;
  for (const Ensemble& ensemble : ensembles) {
    if (ensemble.runs.empty() || !ensemble.runs.front().results.experiment) continue;
    const creep::Experiment& asked = *ensemble.runs.front().results.experiment;
    std::string program = asked.start ? absl::StrCat("from ", asked.start->checkpoint, ": ") : "";
    for (std::size_t i = 0; i < asked.program.size(); ++i)
      absl::StrAppend(&program, i == 0 ? "" : ", ", creep::stage_text(asked.program[i]));
    rows.push_back({ensemble.label, program, asked.material.preset,
                    absl::StrCat(asked.numerics.fidelity, "; ", creep::numerics_text(asked.numerics))});
  }
  return absl::StrCat("<h2>Settings</h2>\n",
                      html_table({"jobs", "program", "material preset", "numerics"}, rows, false));
}

std::string runs_section(const std::vector<Ensemble>& ensembles) {
  Rows rows;
  for (const Ensemble& ensemble : ensembles) {
    for (const ComparedJob& run : ensemble.runs) {
      const JobResults& results = run.results;
      rows.push_back({ensemble.label,
                      results.experiment ? absl::StrCat(results.experiment->specimen.seed) : "–",
                      results.directory.string(), results.text("reason"), results.text("state_digest")});
    }
  }
  return absl::StrCat("<h2>Runs</h2>\n",
                      html_table({"jobs", "seed", "directory", "end", "state digest"}, rows, false));
}

}  // namespace

std::string ensemble_page(const std::string& title, const std::vector<Ensemble>& ensembles) {
  const std::string body = absl::StrCat("<h1>", html_escape(title), "</h1>\n", note_section(ensembles),
                                        figures_section(ensembles), charts_section(ensembles)) +
                           absl::StrCat(settings_section(ensembles), runs_section(ensembles));
  return html_document(absl::StrCat(title, " – creep report"), body);
}

}  // namespace creepctl
