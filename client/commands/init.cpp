#include "client/commands/commands.h"

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <memory>
#include <string>
#include <vector>

#include "client/job_file/job_template.h"
#include "client/terminal/exit_codes.h"
#include "core/experiment/presets.h"

namespace creepctl {
namespace {

struct Options {
  std::string path;  ///< "" = stdout
  std::string preset;
};

int init(const Options& options) {
  const std::string text = job_template(options.preset);
  if (options.path.empty()) {
    std::fputs(text.c_str(), stdout);
    return std::fflush(stdout) == 0 ? kOk : kIoError;
  }
  // "x": an existing file is never overwritten, not even in a race.
  std::FILE* file = std::fopen(options.path.c_str(), "wx");
  if (file == nullptr) {
    const bool exists = errno == EEXIST;
    std::fprintf(stderr, "creepctl: %s: %s\n", options.path.c_str(),
                 exists ? "exists already; it is left as it is" : std::strerror(errno));
    return exists ? kFailed : kIoError;
  }
  const bool written = std::fputs(text.c_str(), file) >= 0;
  const bool closed = std::fclose(file) == 0;
  if (!written || !closed) {
    std::fprintf(stderr, "creepctl: %s: %s\n", options.path.c_str(), std::strerror(errno));
    std::remove(options.path.c_str());
    return kIoError;
  }
  std::fprintf(stderr, "%s written; next: creepctl run %s --out DIR\n", options.path.c_str(),
               options.path.c_str());
  return kOk;
}

}  // namespace

void add_init(CLI::App& app, int& exit_code) {
  CLI::App* command = app.add_subcommand("init", "Writes a commented job file to start from");
  auto options = std::make_shared<Options>();
  const auto names = creep::material_preset_names();
  options->preset = std::string(names.front());
  command->add_option("FILE", options->path, "Where to; standard output if not given. Never overwritten");
  command->add_option("--preset", options->preset, "The material")
      ->check(CLI::IsMember(std::vector<std::string>(names.begin(), names.end())))
      ->capture_default_str();
  command->footer("Example:\n  creepctl init creep.toml");
  command->callback([options, &exit_code] { exit_code = init(*options); });
}

}  // namespace creepctl
