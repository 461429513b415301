#include "client/commands/commands.h"

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <memory>
#include <string>
#include <vector>

#include "client/report/ensemble_page.h"
#include "client/report/ensemble_table.h"
#include "client/report/report_page.h"
#include "client/terminal/exit_codes.h"
#include "client/terminal/terminal.h"

namespace creepctl {
namespace {

struct ReportOptions {
  std::vector<std::string> directories;
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

int fail(const absl::Status& status) {
  complain(std::string(status.message()));
  return kInvalidInput;
}

/// Writes the page and prints its path.
int write_page(const std::filesystem::path& path, const std::string& page) {
  std::ofstream out(path, std::ios::binary | std::ios::trunc);
  out.write(page.data(), static_cast<std::streamsize>(page.size()));
  out.close();
  if (!out) {
    complain("cannot write " + path.string());
    return kIoError;
  }
  std::printf("%s\n", path.c_str());
  return kOk;
}

std::filesystem::path page_path(const ReportOptions& options) {
  if (!options.out.empty()) return options.out;
  return std::filesystem::path(options.directories.front()) / "report.html";
}

int report_job(const ReportOptions& options) {
  const auto results = read_job_results(options.directories.front());
  if (!results.ok()) return fail(results.status());
  const std::optional<Hold> hold = last_hold(*results);
  const int exit_code = write_page(page_path(options), report_page(*results, hold));
  if (exit_code == kOk) print_headline(*results, hold);
  return exit_code;
}

int report_means(const ReportOptions& options) {
  const auto ensembles = read_ensembles(options.directories);
  if (!ensembles.ok()) return fail(ensembles.status());
  std::error_code error;
  const auto plain = std::filesystem::absolute(options.directories.front(), error).lexically_normal();
  const std::string title =
      plain.filename().empty() ? plain.parent_path().filename().string() : plain.filename().string();
  const int exit_code = write_page(page_path(options), ensemble_page(title, *ensembles));
  if (exit_code == kOk) {
    std::printf("%s%s\n", ensemble_table_text(*ensembles, 0).c_str(), confidence_note(*ensembles).c_str());
  }
  return exit_code;
}

int report(const ReportOptions& options) {
  const bool several = options.directories.size() > 1;
  if (several && options.out.empty()) {
    std::fprintf(stderr, "creepctl: report of several directories needs --out\n");
    return kUsage;
  }
  return several || is_folder_of_jobs(options.directories.front()) ? report_means(options)
                                                                   : report_job(options);
}

}  // namespace

void add_report(CLI::App& app, int& exit_code) {
  CLI::App* command = app.add_subcommand(
      "report", "Writes a report as one HTML page: of a job beside the paper, or means of several");
  auto options = std::make_shared<ReportOptions>();
  command
      ->add_option("DIR", options->directories,
                   "Job directory (the --out of run); a sweep's folder or several: means over seeds")
      ->required();
  command->add_option("--out", options->out,
                      "The page (default: DIR/report.html; of several DIR it must be given)");
  command->footer(
      "Works on unfinished runs too; means are of the jobs that have ended.\n\nExample:\n  creepctl report "
      "creep-run --out creep-run.html");
  command->callback([options, &exit_code] { exit_code = report(*options); });
}

}  // namespace creepctl
