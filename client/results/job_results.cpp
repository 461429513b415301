#include "client/results/job_results.h"

#include <fstream>
#include <sstream>
#include <utility>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "core/experiment/experiment_toml.h"

namespace creepctl {
namespace {

absl::StatusOr<std::string> read_text(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  if (!in) return absl::UnavailableError(absl::StrCat("cannot read ", path.string()));
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

absl::StatusOr<NumberTable> read_table(const std::filesystem::path& path) {
  std::error_code error;
  if (!std::filesystem::exists(path, error)) return NumberTable();
  auto text = read_text(path);
  if (!text.ok()) return text.status();
  return NumberTable::parse(*text, path.string());
}

}  // namespace

std::optional<double> JobResults::figure(std::string_view figure_name) const {
  const auto figures = summary.find("figures");
  if (figures == summary.end() || !figures->is_object()) return std::nullopt;
  const auto found = figures->find(std::string(figure_name));
  if (found == figures->end() || !found->is_number()) return std::nullopt;
  return found->get<double>();
}

std::string JobResults::text(std::string_view text_name) const {
  const auto found = summary.find(std::string(text_name));
  return found != summary.end() && found->is_string() ? found->get<std::string>() : std::string();
}

absl::StatusOr<JobResults> read_job_results(const std::filesystem::path& directory) {
  std::error_code error;
  if (!std::filesystem::is_directory(directory, error)) {
    return absl::NotFoundError(absl::StrCat("no such job directory: ", directory.string()));
  }
  if (!std::filesystem::is_regular_file(directory / "job.toml", error)) {
    return absl::InvalidArgumentError(absl::StrCat(
        directory.string(), " is no job directory: it holds no job.toml. Give the --out of 'creepctl run'"));
  }
  JobResults results;
  results.directory = directory;
  auto job_text = read_text(directory / "job.toml");
  if (!job_text.ok()) return job_text.status();
  results.job_text = *std::move(job_text);
  results.experiment = creep::parse_experiment(results.job_text).experiment;
  results.name = results.experiment ? results.experiment->name : "";
  if (results.name.empty()) {
    const auto plain = std::filesystem::absolute(directory, error).lexically_normal();
    results.name =
        plain.filename().empty() ? plain.parent_path().filename().string() : plain.filename().string();
  }
  const std::pair<const char*, NumberTable*> tables[] = {{"samples.csv", &results.samples},
                                                         {"stages.csv", &results.stages},
                                                         {"breakages.csv", &results.breakages},
                                                         {"gsd.csv", &results.grading}};
  for (const auto& [file, table] : tables) {
    auto read = read_table(directory / file);
    if (!read.ok()) return read.status();
    *table = *std::move(read);
  }
  results.summary = nlohmann::ordered_json::object();
  if (std::filesystem::exists(directory / "summary.json", error)) {
    auto text = read_text(directory / "summary.json");
    if (!text.ok()) return text.status();
    auto parsed = nlohmann::ordered_json::parse(*text, nullptr, false);
    if (!parsed.is_object()) {
      return absl::InvalidArgumentError(
          absl::StrCat((directory / "summary.json").string(), " is no JSON object"));
    }
    results.summary = std::move(parsed);
  }
  return results;
}

}  // namespace creepctl
