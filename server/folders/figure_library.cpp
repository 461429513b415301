#include "server/folders/figure_library.h"

#include <utility>

#include <nlohmann/json.hpp>

#include "core/folder/durable_file.h"
#include "core/folder/job_directory.h"

namespace creepd {
namespace {

constexpr std::size_t kLongestSummary = 1 << 20;  // bytes

std::map<std::string, double> figures_in(const std::filesystem::path& folder) {
  std::map<std::string, double> figures;
  const auto text = creep::read_file(creep::JobDirectory(folder).summary(), kLongestSummary);
  if (!text.ok()) return figures;
  const auto summary = nlohmann::json::parse(*text, nullptr, false);
  if (!summary.is_object() || !summary.contains("figures") || !summary["figures"].is_object()) return figures;
  for (const auto& [name, value] : summary["figures"].items()) {
    if (value.is_number()) figures[name] = value.get<double>();
  }
  return figures;
}

}  // namespace

std::map<std::string, double> FigureLibrary::of(const std::filesystem::path& folder) {
  {
    const std::lock_guard lock(mutex_);
    if (const auto found = known_.find(folder.string()); found != known_.end()) return found->second;
  }
  std::map<std::string, double> figures = figures_in(folder);
  const std::lock_guard lock(mutex_);
  if (known_.size() >= kKept) known_.clear();
  known_[folder.string()] = figures;
  return figures;
}

}  // namespace creepd
