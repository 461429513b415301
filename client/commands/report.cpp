#include "client/commands/report.h"

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <memory>
#include <string>

#include "client/exit_codes.h"
#include "client/report_page.h"

namespace creepctl {
namespace {

struct ReportOptions {
  std::string directory;
  std::string out;
};

void print_headline(const JobResults& results, const std::optional<Hold>& hold) {
  for (const Comparison& line : comparisons(results, hold)) {
    std::printf("%s: %s", line.quantity.c_str(), line.run.c_str());
    if (line.paper != "–") std::printf(" | paper %s", line.paper.c_str());
    if (line.difference != "–") std::printf(" | difference %s", line.difference.c_str());
    if (line.difference != "–" && !line.scatter.empty())
      std::printf(" (one packing: %s)", line.scatter.c_str());
    std::printf("\n");
  }
  if (!paper_scene(results).compression) std::printf("Not the paper's scene: nothing to compare with.\n");
}

int report(const ReportOptions& options) {
  const auto results = read_job_results(options.directory);
  if (!results.ok()) {
    std::fprintf(stderr, "error: %s\n", std::string(results.status().message()).c_str());
    return kInvalidInput;
  }
  const std::optional<Hold> hold = last_hold(*results);
  const std::string page = report_page(*results, hold);
  const std::filesystem::path path =
      options.out.empty() ? results->directory / "report.html" : std::filesystem::path(options.out);
  std::ofstream out(path, std::ios::binary | std::ios::trunc);
  out.write(page.data(), static_cast<std::streamsize>(page.size()));
  out.close();
  if (!out) {
    std::fprintf(stderr, "error: cannot write %s\n", path.c_str());
    return kIoError;
  }
  std::printf("%s\n", path.c_str());
  print_headline(*results, hold);
  return kOk;
}

}  // namespace

void add_report(CLI::App& app, int& exit_code) {
  CLI::App* command =
      app.add_subcommand("report", "Writes a job's report as one HTML page, beside the paper's figures");
  auto options = std::make_shared<ReportOptions>();
  command->add_option("DIR", options->directory, "Job directory (the --out of run)")->required();
  command->add_option("--out", options->out, "The page (default: DIR/report.html)");
  command->footer(
      "Works on unfinished runs too.\n\nExample:\n  creepctl report creep-run --out creep-run.html");
  command->callback([options, &exit_code] { exit_code = report(*options); });
}

}  // namespace creepctl
