#include "client/commands/commands.h"

#include <cstdio>
#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>
#include <sstream>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "client/charts/chart_files.h"
#include "client/report/ensemble_charts.h"
#include "client/report/ensemble_table.h"
#include "client/report/overlay.h"
#include "client/terminal/exit_codes.h"
#include "client/terminal/table.h"
#include "client/terminal/terminal.h"

namespace creepctl {
namespace {

using nlohmann::ordered_json;

struct Options {
  std::vector<std::string> directories;
  std::vector<std::string> laboratory;
  std::string out;
  std::string format = "both";
  bool mean = false;
  bool json = false;
};

absl::StatusOr<std::vector<LaboratoryCurve>> read_laboratory(const std::vector<std::string>& paths) {
  std::vector<LaboratoryCurve> curves;
  for (const std::string& path : paths) {
    std::ifstream file(path, std::ios::binary);
    std::ostringstream text;
    if (!file || !(text << file.rdbuf()))
      return absl::InvalidArgumentError(absl::StrCat(path, ": cannot be read, or is empty"));
    auto curve = parse_laboratory_curve(text.str(), path);
    if (!curve.ok()) return curve.status();
    curve->name = std::filesystem::path(path).stem().string();
    curves.push_back(*std::move(curve));
  }
  return curves;
}

ordered_json to_json(const std::optional<double>& value) {
  return value ? ordered_json(*value) : ordered_json(nullptr);
}

void print_json(const std::vector<ComparedJob>& jobs) {
  ordered_json list = ordered_json::array();
  for (const ComparedJob& job : jobs) {
    const ComparedFigures figures = compared_figures(job);
    ordered_json value = {{"job", job.label},
                          {"directory", job.results.directory.string()},
                          {"void_ratio_before_creep", to_json(figures.void_ratio_before)},
                          {"creep_strain", to_json(figures.creep_strain)},
                          {"singh_mitchell_m", to_json(figures.m)},
                          {"rate_10_min_percent_per_min", to_json(figures.rate_10_min)},
                          {"grading_index", to_json(figures.grading_index)},
                          {"paper", paper_json(figures.paper)}};
    list.push_back(std::move(value));
  }
  std::printf("%s\n", list.dump(2, ' ', false, ordered_json::error_handler_t::replace).c_str());
}

std::string cell(const std::optional<double>& value, double factor = 1.0) {
  return value ? absl::StrFormat("%.3g", factor * *value) : "-";
}

void print_table(const std::vector<ComparedJob>& jobs) {
  Table table({{"JOB"},
               {"E BEFORE", Align::kRight},
               {"CREEP %", Align::kRight},
               {"I_G", Align::kRight},
               {"M", Align::kRight},
               {"%/MIN AT 10 MIN", Align::kRight},
               {"PAPER q/q_max", Align::kRight},
               {"M", Align::kRight},
               {"%/MIN", Align::kRight}});
  for (const ComparedJob& job : jobs) {
    const ComparedFigures figures = compared_figures(job);
    std::optional<double> ratio, m, rate;
    if (figures.paper) {
      ratio = figures.paper->stress_ratio;
      m = figures.paper->m;
      rate = figures.paper->rate_10_min;
    }
    table.add({job.label, cell(figures.void_ratio_before), cell(figures.creep_strain, 100.0),
               cell(figures.grading_index), cell(figures.m), cell(figures.rate_10_min), cell(ratio), cell(m),
               cell(rate)});
  }
  std::printf("%s", table.text(is_terminal(stdout) ? terminal_width(stdout) : 0).c_str());
}

void print_means(const std::vector<Ensemble>& ensembles, bool json) {
  if (json) {
    const auto list = ensembles_json(ensembles);
    std::printf("%s\n", list.dump(2, ' ', false, ordered_json::error_handler_t::replace).c_str());
    return;
  }
  const int width = is_terminal(stdout) ? terminal_width(stdout) : 0;
  std::printf("%s%s\n", ensemble_table_text(ensembles, width).c_str(), confidence_note(ensembles).c_str());
}

/// Prints the figures; the charts for --out. Error: of reading.
absl::StatusOr<std::vector<NamedChart>> compare_means(const Options& options,
                                                      const std::vector<LaboratoryCurve>& laboratory) {
  const auto ensembles = read_ensembles(options.directories);
  if (!ensembles.ok()) return ensembles.status();
  print_means(*ensembles, options.json);
  return ensemble_charts(*ensembles, laboratory);
}

/// The same job by job.
absl::StatusOr<std::vector<NamedChart>> compare_jobs(const Options& options,
                                                     const std::vector<LaboratoryCurve>& laboratory) {
  const auto directories = job_directories(options.directories);
  if (!directories.ok()) return directories.status();
  const auto jobs = read_compared_jobs(*directories);
  if (!jobs.ok()) return jobs.status();
  if (options.json) {
    print_json(*jobs);
  } else {
    print_table(*jobs);
  }
  return overlay_charts(*jobs, laboratory);
}

int compare(const Options& options) {
  const auto laboratory = read_laboratory(options.laboratory);
  if (!laboratory.ok()) {
    complain(std::string(laboratory.status().message()));
    return kInvalidInput;
  }
  const auto charts = options.mean ? compare_means(options, *laboratory) : compare_jobs(options, *laboratory);
  if (!charts.ok()) {
    complain(std::string(charts.status().message()));
    return kInvalidInput;
  }
  if (options.out.empty()) return kOk;
  if (const auto written = write_charts(options.out, options.format, *charts); !written.ok()) {
    complain(std::string(written.message()));
    return kIoError;
  }
  return kOk;
}

}  // namespace

void add_compare(CLI::App& app, int& exit_code) {
  CLI::App* command =
      app.add_subcommand("compare", "Sets jobs beside one another, the paper and a laboratory");
  auto options = std::make_shared<Options>();
  command
      ->add_option("DIR", options->directories,
                   "Job directories (the --out of run), or folders with such in them")
      ->required();
  command->add_option(
      "--laboratory", options->laboratory,
      "Measured creep curve: csv with the columns age_s and axial_strain, both since the hold "
      "began; can be given again");
  command->add_option("--out", options->out, "Folder for the charts; none are drawn without it");
  command->add_option("--format", options->format, "svg, png or both")
      ->check(CLI::IsMember({"svg", "png", "both"}));
  command->add_flag("--mean", options->mean,
                    "Means over jobs that differ in nothing but the seed, with their 95 % intervals");
  command->add_flag("--json", options->json, "Print the figures as JSON on stdout");
  command->footer(
      "Prints the figures of the last creep stage of each job. The paper's m and rate (Table 2) stand "
      "beside\n"
      "a job that holds one of its stress ratios at 10 MPa. Charts: creep strain and grading index over log\n"
      "time, void ratio over log stress, with a curve for every job; with --mean means and their bands.\n"
      "Exit code 0: compared; 5: a directory or file is no such thing; 74: a chart could not be written.\n\n"
      "Example:\n  creepctl compare seed-1 seed-2 --laboratory oedometer.csv --out compared\n"
      "  creepctl compare sweep --mean");
  command->callback([options, &exit_code] { exit_code = compare(*options); });
}

}  // namespace creepctl
