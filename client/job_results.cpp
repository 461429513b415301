#include "client/job_results.h"

#include <algorithm>
#include <charconv>
#include <fstream>
#include <limits>
#include <sstream>
#include <utility>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "core/experiment/experiment_toml.h"

namespace creepctl {
namespace {

std::vector<std::string_view> split(std::string_view line) {
  std::vector<std::string_view> cells;
  for (std::size_t begin = 0;;) {
    const std::size_t comma = line.find(',', begin);
    cells.push_back(line.substr(begin, comma == std::string_view::npos ? comma : comma - begin));
    if (comma == std::string_view::npos) return cells;
    begin = comma + 1;
  }
}

std::string_view without_return(std::string_view line) {
  return !line.empty() && line.back() == '\r' ? line.substr(0, line.size() - 1) : line;
}

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

absl::StatusOr<NumberTable> NumberTable::parse(std::string_view text, std::string_view name) {
  NumberTable table;
  std::size_t line_number = 0;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = text.find('\n', begin);
    if (end == std::string_view::npos) break;
    const std::string_view line = without_return(text.substr(begin, end - begin));
    begin = end + 1;
    ++line_number;
    if (line.empty()) continue;
    const std::vector<std::string_view> cells = split(line);
    if (table.names_.empty()) {
      for (const std::string_view cell : cells) table.names_.emplace_back(cell);
      table.columns_.resize(cells.size());
      continue;
    }
    const std::string place = absl::StrCat(std::string(name), ":", line_number, ": ");
    if (cells.size() != table.names_.size()) {
      return absl::InvalidArgumentError(
          absl::StrCat(place, cells.size(), " values under a header of ", table.names_.size()));
    }
    for (std::size_t i = 0; i < cells.size(); ++i) {
      double value = 0.0;
      const char* cell_end = cells[i].data() + cells[i].size();
      const auto [stopped, problem] = std::from_chars(cells[i].data(), cell_end, value);
      if (problem != std::errc() || stopped != cell_end) {
        return absl::InvalidArgumentError(absl::StrCat(place, "'", std::string(cells[i]), "' is no number"));
      }
      table.columns_[i].push_back(value);
    }
  }
  return table;
}

bool NumberTable::has(std::string_view column) const {
  return std::find(names_.begin(), names_.end(), column) != names_.end();
}

const std::vector<double>& NumberTable::column(std::string_view name) const {
  static const std::vector<double> kNone;
  const auto found = std::find(names_.begin(), names_.end(), name);
  return found == names_.end() ? kNone : columns_[static_cast<std::size_t>(found - names_.begin())];
}

double NumberTable::at(std::size_t row, std::string_view column_name) const {
  const std::vector<double>& values = column(column_name);
  return row < values.size() ? values[row] : std::numeric_limits<double>::quiet_NaN();
}

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
