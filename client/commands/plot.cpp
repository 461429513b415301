#include "client/commands/commands.h"

#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "client/charts/chart_files.h"
#include "client/report/ensemble_charts.h"
#include "client/report/result_charts.h"
#include "client/terminal/exit_codes.h"
#include "client/terminal/terminal.h"

namespace creepctl {
namespace {

struct PlotOptions {
  std::vector<std::string> directories;
  std::string out;
  std::string format = "both";
};

int fail(const absl::Status& status, int exit_code) {
  complain(std::string(status.message()));
  return exit_code;
}

/// The charts of one job.
absl::StatusOr<std::vector<NamedChart>> charts_of_job(const std::string& directory) {
  const auto results = read_job_results(directory);
  if (!results.ok()) return results.status();
  return result_charts(*results, last_hold(*results));
}

/// The means of several.
absl::StatusOr<std::vector<NamedChart>> charts_of_means(const std::vector<std::string>& given) {
  const auto ensembles = read_ensembles(given);
  if (!ensembles.ok()) return ensembles.status();
  return ensemble_charts(*ensembles, {});
}

int plot(const PlotOptions& options) {
  const std::string& first = options.directories.front();
  const bool several = options.directories.size() > 1;
  if (several && options.out.empty()) {
    complain("plot of several directories needs --out");
    return kUsage;
  }
  const bool one_job = !several && !is_folder_of_jobs(first);
  const auto charts = one_job ? charts_of_job(first) : charts_of_means(options.directories);
  if (!charts.ok()) return fail(charts.status(), kInvalidInput);
  if (charts->empty()) {
    std::fprintf(stderr, "nothing to plot yet: %s in %s\n",
                 one_job ? "the specimen is not packed" : "no job has ended", first.c_str());
    return kOk;
  }
  const std::filesystem::path out =
      options.out.empty() ? std::filesystem::path(first) / "plots" : std::filesystem::path(options.out);
  const absl::Status written = write_charts(out, options.format, *charts);
  return written.ok() ? kOk : fail(written, kIoError);
}

}  // namespace

void add_plot(CLI::App& app, int& exit_code) {
  CLI::App* command =
      app.add_subcommand("plot", "Draws the charts of a job, finished or not, or the means of several");
  auto options = std::make_shared<PlotOptions>();
  command
      ->add_option("DIR", options->directories,
                   "Job directory (the --out of run); a sweep's folder or several: means over seeds")
      ->required();
  command->add_option("--out", options->out,
                      "Folder for the pictures (default: DIR/plots; of several DIR it must be given)");
  command->add_option("--format", options->format, "svg, png or both")
      ->check(CLI::IsMember({"svg", "png", "both"}));
  command->footer(
      "Prints the files it wrote. Charts without data are left out. Of jobs that differ in nothing but the "
      "seed\n"
      "the mean is drawn with its 95 % band (Student's t).\n\n"
      "Example:\n  creepctl plot creep-run --format png\n  creepctl plot sweep");
  command->callback([options, &exit_code] { exit_code = plot(*options); });
}

}  // namespace creepctl
