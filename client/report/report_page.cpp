#include "client/report/report_page.h"

#include <algorithm>
#include <cmath>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_replace.h"
#include "client/report/html.h"
#include "client/report/result_charts.h"
#include "client/results/broken_fraction.h"
#include "core/experiment/numerics_text.h"
#include "core/experiment/stage_text.h"

namespace creepctl {
namespace {

using Rows = std::vector<std::vector<std::string>>;

constexpr double kPercentPerMinute = 6000.0;  // of a rate in 1/s
constexpr double kTenMinutes = 600.0;         // [s]

std::string number(double value, const char* pattern) {
  if (!std::isfinite(value)) return "–";
  char text[64];
  std::snprintf(text, sizeof text, pattern, value);
  return text;
}

std::string summary_number(const JobResults& results, const char* name, const char* pattern) {
  const auto found = results.summary.find(name);
  return found != results.summary.end() && found->is_number() ? number(found->get<double>(), pattern) : "–";
}

std::string outcome_text(const JobResults& results) {
  const std::string outcome = results.text("outcome");
  const std::string reason = results.text("reason");
  if (outcome.empty()) return "not ended: the figures are those so far";
  return reason.empty() || reason == outcome ? outcome : absl::StrCat(outcome, " (", reason, ")");
}

std::string header(const JobResults& results) {
  Rows rows = {{"outcome", outcome_text(results)}};
  if (const auto& particles = results.samples.column("particles"); !particles.empty()) {
    rows.push_back({"particles",
                    absl::StrFormat("%.0f at first, %.0f at the end", particles.front(), particles.back())});
  }
  if (results.experiment) {
    const creep::Experiment& asked = *results.experiment;
    std::string program;
    for (const creep::Stage& stage : asked.program) {
      absl::StrAppend(&program, program.empty() ? "" : ", ", creep::stage_text(stage));
    }
    rows.push_back({"program", program});
    rows.push_back({"void ratio asked for", absl::StrFormat("%.4g", asked.specimen.void_ratio)});
    rows.push_back({"seed", absl::StrCat(asked.specimen.seed)});
    rows.push_back({"material preset", asked.material.preset});
    rows.push_back({"fidelity", absl::StrFormat("%s, at least %d cycles a dynamic stage",
                                                asked.numerics.fidelity, asked.numerics.minimum_cycles)});
    rows.push_back({"numerics", creep::numerics_text(asked.numerics)});
  }
  const auto text_row = [&](const char* label, const char* name) {
    if (const std::string text = results.text(name); !text.empty()) rows.push_back({label, text});
  };
  text_row("state digest", "state_digest");
  text_row("experiment hash", "experiment_hash");
  text_row("arithmetic", "arithmetic_id");
  return absl::StrCat("<h1>", html_escape(results.name), "</h1>\n", html_table({}, rows, false));
}

std::string warnings(const JobResults& results) {
  std::string out;
  const auto found = results.summary.find("warnings");
  if (found == results.summary.end() || !found->is_array()) return out;
  for (const auto& warning : *found) {
    if (!warning.is_string()) continue;
    absl::StrAppend(&out, "<p class=\"warning\">", html_escape(warning.get<std::string>()), "</p>\n");
  }
  return out;
}

std::string comparison_section(const JobResults& results, const std::optional<Hold>& hold) {
  Rows rows;
  for (const Comparison& line : comparisons(results, hold)) {
    rows.push_back({absl::StrReplaceAll(line.quantity, {{"I_G", "I_{G}"}}), line.run, line.paper,
                    line.difference, line.scatter});
  }
  const PaperScene scene = paper_scene(results);
  std::string note = one_packing_note();
  if (scene.creep)
    absl::StrAppend(&note, " Whether the paper's 15 stages include the initial one is not stated.");
  if (!scene.compression) {
    absl::StrAppend(&note,
                    " This job is not the paper's scene (Fontainebleau NE34 from e = 0.65 to 21.7 MPa in the "
                    "oedometer), so its figures are not set beside the paper's.");
  } else if (!scene.creep) {
    absl::StrAppend(&note, " Only the compression is the paper's scene (creep there: 2 d at 21.7 MPa).");
  }
  return absl::StrCat(
      "<h2>Beside the paper (Lei, Arroyo, Ciantia &amp; Zhang)</h2>\n",
      html_table({"", "this run", "paper", "difference", "scatter of one packing"}, rows, false), "<p>",
      html_escape(note), "</p>\n");
}

std::string phase_text(const creep::CreepAnalysis& analysis) {
  if (!analysis.phase) return "–";
  switch (*analysis.phase) {
    case creep::CreepPhase::kPrimary:
      return "primary (the rate falls)";
    case creep::CreepPhase::kSecondary:
      return "secondary (the rate is about constant)";
    case creep::CreepPhase::kTertiary:
      return "tertiary (the rate rises)";
  }
  return "–";
}

std::string analysis_section(const JobResults& results, const std::optional<Hold>& hold) {
  if (!hold || hold->stage_rows.empty()) return "";
  const creep::CreepAnalysis& analysis = hold->analysis;
  Rows rows = {{"phase reached", phase_text(analysis)}};
  if (const auto& fit = analysis.primary_fit; fit) {
    rows.push_back({"Singh-Mitchell m", absl::StrFormat("%.3f ± %.3f (standard error of the fit)", fit->m,
                                                        fit->m_standard_error)});
    rows.push_back({"fit window",
                    absl::StrCat(duration_text(fit->window_begin), " to ", duration_text(fit->window_end))});
    rows.push_back(
        {"points", absl::StrFormat("%d used, %d without a logarithm left out", fit->points, fit->omitted)});
    rows.push_back({"R²", fit->r_squared ? absl::StrFormat("%.4f", *fit->r_squared) : "–"});
    rows.push_back(
        {"rate at 10 min", absl::StrFormat("%.3g %%/min%s", kPercentPerMinute * fit->rate(kTenMinutes),
                                           fit->covers(kTenMinutes) ? "" : " (extrapolated)")});
  } else {
    rows.push_back({"Singh-Mitchell m", "– (fewer than 3 rates of primary creep)"});
  }
  if (const auto& onset = analysis.tertiary; onset) {
    rows.push_back({"onset of tertiary creep",
                    absl::StrCat(duration_text(onset->creep_time), " (", duration_text(onset->earliest),
                                 " to ", duration_text(onset->latest), ")")});
  } else {
    rows.push_back({"onset of tertiary creep", "none seen"});
  }
  if (const auto failed_at = results.figure("creep_time_s");
      failed_at && results.text("outcome") == "creep_failure") {
    rows.push_back({"time to failure", duration_text(*failed_at)});
  }
  return absl::StrCat(
      "<h2>Creep analysis</h2>\n", html_table({}, rows, false),
      "<p class=\"muted\">Strain is taken at the ends of the dynamic stages and is piecewise "
      "linear in ln(creep time); the "
      "rate is its slope over the time, at the geometric middle of each interval. m is "
      "fitted by least squares of log rate "
      "on log time over primary creep only; with 5 to 14 points it is uncertain by about "
      "±0.2. Tertiary creep begins "
      "where the rate smoothed over three intervals, or a factor of 2 in time if that is more, "
      "is least, if it later doubles (or rises further, where "
      "the rates scatter so much that doubling says nothing).</p>\n");
}

std::string charts_section(const JobResults& results, const std::optional<Hold>& hold) {
  std::string out = "<h2>Plots</h2>\n";
  const auto charts = result_charts(results, hold);
  for (std::size_t i = 0; i < charts.size(); ++i) {
    absl::StrAppend(&out,
                    html_figure(draw_svg(charts[i].chart, absl::StrCat("p", i, "-")), charts[i].caption));
  }
  if (charts.empty()) out += "<p>None yet: the specimen is not packed.</p>\n";
  return out;
}

std::string stages_section(const JobResults& results) {
  const NumberTable& stages = results.stages;
  Rows rows;
  for (std::size_t row = 0; row < stages.rows(); ++row) {
    const auto cell = [&](const char* column, const char* pattern, double factor = 1.0) {
      return number(factor * stages.at(row, column), pattern);
    };
    const bool loading = stages.at(row, "dynamic_stage") < 0.0;
    const auto place = static_cast<std::size_t>(stages.at(row, "stage"));
    const bool known = results.experiment && place < results.experiment->program.size();
    const std::string name =
        known ? std::string(creep::stage_name(results.experiment->program[place])) : "loading";
    rows.push_back({loading ? name : cell("dynamic_stage", "%.0f"), cell("cycles", "%.0f"),
                    loading ? "–" : duration_text(stages.at(row, "creep_time_start_s")),
                    cell("axial_strain_end", "%.4f", 100.0), cell("void_ratio_end", "%.4f"),
                    cell("axial_stress_end_Pa", "%.3f", 1e-6), cell("grading_index_end", "%.4f"),
                    loading ? "–" : cell("ripple", "%.2f", 100.0), cell("broken_at_start", "%.0f"),
                    cell("broken_during", "%.0f"), cell("particles", "%.0f"),
                    cell("time_step_s", "%.2f", 1e9), stages.at(row, "settled") == 1.0 ? "yes" : "no",
                    cell("rebuilds", "%.0f"), cell("wall_seconds", "%.1f")});
  }
  if (rows.empty()) return "";
  return absl::StrCat("<h2>Stages</h2>\n",
                      html_table({"dynamic stage", "cycles", "creep time", "ε_{a} (%)", "e", "σ_{a} (MPa)",
                                  "I_{G}", "ripple (%)", "broken at start", "broken during", "particles",
                                  "step (ns)", "settled", "searches", "wall time (s)"},
                                 rows, true),
                      "<p class=\"muted\">Axial strain since the end of packing; e, stress and grading index "
                      "at the end of the stage; "
                      "creep time at its beginning.</p>\n");
}

std::string ledger_section(const JobResults& results) {
  const NumberTable& samples = results.samples;
  if (samples.rows() == 0) return "";
  const std::size_t last = samples.rows() - 1;
  const double work = samples.at(last, "wall_work_J");
  Rows rows;
  const auto add = [&](const char* label, const char* column) {
    const double value = samples.at(last, column);
    const double part = std::fabs(work) > 0.0 ? 100.0 * value / work : std::nan("");
    rows.push_back({label, number(value, "%.5e"), number(part, "%.4f")});
  };
  add("wall work", "wall_work_J");
  add("normal elastic", "normal_elastic_J");
  add("tangential elastic", "tangential_elastic_J");
  add("friction", "friction_J");
  add("local damping", "damping_J");
  add("kinetic", "kinetic_J");
  add("removed with broken particles", "removed_J");
  add("residual of the tangential law", "tangential_residual_J");
  add("unexplained", "energy_unexplained_J");
  return absl::StrCat("<h2>Ledgers</h2>\n",
                      html_table({"since the end of packing", "J", "% of wall work"}, rows, true),
                      "<p>Mass of particles and fines over the initial mass, less 1: ",
                      number(samples.at(last, "mass_unexplained"), "%.2e"), ".</p>\n");
}

std::string breakage_section(const JobResults& results) {
  const auto& cause = results.breakages.column("cause");
  const auto& diameter = results.breakages.column("diameter_m");
  const auto& generation = results.breakages.column("generation");
  const auto& creep_time = results.breakages.column("creep_time_s");
  const char* const names[] = {"immediate (σ_{mob} > σ_{lim})", "crack, in a dynamic stage",
                               "crack, in ageing", "all"};
  Rows rows;
  for (int wanted = 0; wanted < 4; ++wanted) {
    std::size_t loading = 0;
    std::size_t creeping = 0;
    std::size_t fragments = 0;
    double sum = 0.0;
    for (std::size_t i = 0; i < cause.size(); ++i) {
      if (wanted < 3 && cause[i] != wanted) continue;
      ++(i < creep_time.size() && creep_time[i] > 0.0 ? creeping : loading);
      fragments += i < generation.size() && generation[i] > 0.0;
      sum += i < diameter.size() ? diameter[i] : std::nan("");
    }
    const std::size_t count = loading + creeping;
    rows.push_back({names[wanted], absl::StrCat(loading), absl::StrCat(creeping), absl::StrCat(fragments),
                    count > 0 ? number(1e3 * sum / static_cast<double>(count), "%.4f") : "–"});
  }
  Rows sizes;
  for (const BrokenFraction& one : broken_fractions(results)) {
    sizes.push_back({absl::StrFormat("%.3f–%.3f", 1e3 * one.smallest, 1e3 * one.largest),
                     absl::StrFormat("%.2f", 100.0 * one.fraction.front()),
                     absl::StrFormat("%.2f", 100.0 * one.fraction.back())});
  }
  const std::string by_size =
      sizes.empty()
          ? ""
          : html_table({"diameter (mm)", "broken at the first grading of the hold (% of those present)",
                        "at the last (%)"},
                       sizes, true);
  std::string relative;
  const auto hardin = results.figure("breakage_hardin"), einav = results.figure("breakage_einav");
  if (hardin && einav) {
    relative = absl::StrFormat(
        "<p>Relative breakage, of the grading at the end against that after packing: Hardin's B<sub>r</sub> "
        "= "
        "%.4f, Einav's B<sub>r</sub>* = %.4f.</p>\n",
        *hardin, *einav);
  }
  return absl::StrCat(
      "<h2>Breakage</h2>\n",
      html_table({"cause", "while loading", "while creeping", "of these fragments", "mean diameter (mm)"},
                 rows, true),
      by_size, relative);
}

std::string cost_section(const JobResults& results) {
  if (results.text("outcome").empty()) return "";
  const Rows rows = {
      {"particle-steps per second", summary_number(results, "particle_steps_per_second", "%.3e")},
      {"wall time of computing (s)", summary_number(results, "wall_seconds", "%.1f")},
      {"threads", summary_number(results, "threads", "%.0f")},
      {"attempts", summary_number(results, "attempts", "%.0f")}};
  return absl::StrCat("<h2>Speed</h2>\n", html_table({}, rows, false));
}

std::string readings_section(const JobResults& results) {
  std::string out = "<h2>Open readings used</h2>\n";
  if (results.experiment) {
    const creep::Material& used = results.experiment->material;
    const char* const layouts[] = {"octahedral", "cubic", "tetrahedral"};
    const Rows rows = {
        {"size exponent k of the strength", absl::StrFormat("%.5g", used.size_exponent)},
        {"reference diameter d_{0}", absl::StrFormat("%.4g mm", used.reference_diameter * 1e3)},
        {"mean strength σ_{lim0} at d_{0}", absl::StrFormat("%.4g GPa", used.limit_stress / 1e9)},
        {"roughness S_{q} of a pair", absl::StrFormat("%.4g µm", used.roughness * 1e6)},
        {"wall contact stiffness factor", absl::StrFormat("%.4g", used.wall_stiffness_factor)},
        {"friction at the walls", absl::StrFormat("%.4g", used.wall_friction)},
        {"rotation of grains", used.free_rotation ? "free" : "blocked"},
        {"floor of the relative strength", absl::StrFormat("%.4g", used.strength_floor)},
        {"layout of the 14 fragments", layouts[static_cast<int>(used.split_layout)]},
        {"fines in the void ratio", "counted as solid"},
        {"local damping", absl::StrFormat("%.4g", results.experiment->numerics.local_damping)},
        {"unbalanced force ratio of a settled stage",
         absl::StrFormat("%.3g", results.experiment->numerics.unbalanced_tolerance)},
        {"closing speed of the platens",
         absl::StrFormat("%.4g m/s", results.experiment->numerics.loading_velocity)}};
    absl::StrAppend(&out, "<p>The paper does not settle these; they are inputs of the job.</p>\n",
                    html_table({}, rows, false));
  }
  return absl::StrCat(out, "<h2>Job file</h2>\n<pre>", html_escape(results.job_text), "</pre>\n");
}

}  // namespace

std::string report_page(const JobResults& results, const std::optional<Hold>& hold) {
  const std::string body =
      absl::StrCat(header(results), warnings(results), comparison_section(results, hold),
                   analysis_section(results, hold), charts_section(results, hold), stages_section(results),
                   breakage_section(results)) +
      absl::StrCat(ledger_section(results), cost_section(results), readings_section(results));
  return html_document(absl::StrCat(results.name, " – creep report"), body);
}

}  // namespace creepctl
