#include "client/commands/commands.h"

#include <algorithm>
#include <charconv>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "client/local/run_folder.h"
#include "client/terminal/exit_codes.h"
#include "client/terminal/terminal.h"
#include "core/state/checkpoint.h"

namespace creepctl {
namespace {

using nlohmann::ordered_json;

/// The files ck.N of a job directory or of its folder of checkpoints, the newest first.
std::vector<std::filesystem::path> checkpoints_in(const std::filesystem::path& folder) {
  std::error_code error;
  const auto inner = folder / "checkpoints";
  std::vector<std::pair<std::uint64_t, std::filesystem::path>> found;
  const auto& place = std::filesystem::is_directory(inner, error) ? inner : folder;
  for (std::filesystem::directory_iterator entry(place, error), end; !error && entry != end;
       entry.increment(error)) {
    const std::string name = entry->path().filename().string();
    std::uint64_t number = 0;
    if (!name.starts_with("ck.")) continue;
    const auto parsed = std::from_chars(name.data() + 3, name.data() + name.size(), number);
    if (parsed.ec == std::errc() && parsed.ptr == name.data() + name.size())
      found.emplace_back(number, entry->path());
  }
  std::sort(found.rbegin(), found.rend());
  std::vector<std::filesystem::path> paths;
  for (const auto& [number, path] : found) paths.push_back(path);
  return paths;
}

ordered_json to_json(const std::filesystem::path& path, const absl::StatusOr<creep::CheckpointInfo>& info) {
  ordered_json value = {{"file", path.string()}, {"good", info.ok()}};
  if (!info.ok()) {
    value[absl::IsFailedPrecondition(info.status()) ? "newer" : "damage"] =
        std::string(info.status().message());
    return value;
  }
  value["stage"] = info->stage;
  value["cycle"] = info->cycle;
  value["age_s"] = info->age;
  value["dynamic_time_s"] = info->dynamic_time;
  value["creep_time_s"] = info->creep_time;
  value["axial_strain"] = info->axial_strain;
  value["broken_total"] = info->broken_total;
  value["particles"] = info->particles;
  value["next_sequence"] = info->next_sequence;
  value["state_digest"] = info->state_digest;
  value["experiment_hash"] = info->experiment_hash;
  value["arithmetic_id"] = info->arithmetic_id;
  value["inexact"] = info->inexact;
  value["format_version"] = info->format_version;
  return value;
}

std::string verdict_on(const ordered_json& checkpoint) {
  if (checkpoint["good"].get<bool>()) return "good, every checksum verified";
  if (checkpoint.contains("newer"))
    return red("not readable:", stdout) + " " + checkpoint["newer"].get<std::string>();
  return red("damaged:", stdout) + " " + checkpoint["damage"].get<std::string>();
}

void print_text(const ordered_json& checkpoint) {
  std::printf("%s: %s\n", checkpoint["file"].get<std::string>().c_str(), verdict_on(checkpoint).c_str());
  for (const auto& [name, value] : checkpoint.items()) {
    if (name == "file" || name == "good" || name == "damage" || name == "newer") continue;
    const std::string shown = value.is_string() ? value.get<std::string>() : value.dump();
    std::printf("  %-16s %s\n", name.c_str(), shown.c_str());
  }
}

int show(const std::string& given, bool json) {
  std::error_code error;
  const bool is_folder = std::filesystem::is_directory(given, error);
  if (!is_folder && !std::filesystem::is_regular_file(given, error)) {
    std::fprintf(stderr, "creepctl: %s: no such file or directory\n", given.c_str());
    return kInvalidInput;
  }
  const auto paths = is_folder ? checkpoints_in(given) : std::vector<std::filesystem::path>{given};
  if (paths.empty()) {
    std::fprintf(stderr, "creepctl: %s: holds no checkpoint\n", given.c_str());
    return kInvalidInput;
  }
  ordered_json all = ordered_json::array();
  bool good = true;
  for (const auto& path : paths) {
    all.push_back(to_json(path, creep::read_checkpoint_info(read_text(path))));
    good = good && all.back()["good"].get<bool>();
    if (!json) print_text(all.back());
  }
  if (json) {
    const ordered_json& shown = is_folder ? all : all.front();
    std::printf("%s\n", shown.dump(2, ' ', false, ordered_json::error_handler_t::replace).c_str());
  }
  return good ? kOk : kInvalidInput;
}

struct Options {
  std::string path;
  bool json = false;
};

}  // namespace

void add_checkpoint(CLI::App& app, int& exit_code) {
  CLI::App* group = app.add_subcommand("checkpoint", "Looks at checkpoints");
  group->require_subcommand(1);
  group->footer("Example:\n  creepctl checkpoint show creep-2d");
  CLI::App* command = group->add_subcommand("show", "Verifies a checkpoint and shows what it says of itself");
  auto options = std::make_shared<Options>();
  command->add_option("PATH", options->path, "A checkpoint, or a job directory: all of it, the newest first")
      ->required();
  command->add_flag("--json", options->json, "Print JSON");
  command->footer(
      "Exit code 0: every checkpoint shown is good; 5: one is damaged, or there is none.\n\n"
      "Example:\n  creepctl checkpoint show creep-2d/checkpoints/ck.12 --json");
  command->callback([options, &exit_code] { exit_code = show(options->path, options->json); });
}

}  // namespace creepctl
