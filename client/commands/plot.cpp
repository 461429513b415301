#include "client/commands/plot.h"

#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>

#include "client/chart_files.h"
#include "client/exit_codes.h"
#include "client/result_charts.h"

namespace creepctl {
namespace {

struct PlotOptions {
  std::string directory;
  std::string out;
  std::string format = "both";
};

int fail(const absl::Status& status, int exit_code) {
  std::fprintf(stderr, "error: %s\n", std::string(status.message()).c_str());
  return exit_code;
}

int plot(const PlotOptions& options) {
  const auto results = read_job_results(options.directory);
  if (!results.ok()) return fail(results.status(), kInvalidInput);
  const auto charts = result_charts(*results, last_hold(*results));
  if (charts.empty()) {
    std::fprintf(stderr, "nothing to plot yet: the specimen in %s is not packed\n",
                 options.directory.c_str());
    return kOk;
  }
  const std::filesystem::path out =
      options.out.empty() ? results->directory / "plots" : std::filesystem::path(options.out);
  const absl::Status written = write_charts(out, options.format, charts);
  return written.ok() ? kOk : fail(written, kIoError);
}

}  // namespace

void add_plot(CLI::App& app, int& exit_code) {
  CLI::App* command = app.add_subcommand("plot", "Draws the charts of a job, finished or not");
  auto options = std::make_shared<PlotOptions>();
  command->add_option("DIR", options->directory, "Job directory (the --out of run)")->required();
  command->add_option("--out", options->out, "Folder for the pictures (default: DIR/plots)");
  command->add_option("--format", options->format, "svg, png or both")
      ->check(CLI::IsMember({"svg", "png", "both"}));
  command->footer(
      "Prints the files it wrote. Charts without data are left out.\n\nExample:\n  creepctl plot creep-run "
      "--format png");
  command->callback([options, &exit_code] { exit_code = plot(*options); });
}

}  // namespace creepctl
