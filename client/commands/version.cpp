#include "client/commands/version.h"

#include <cstdio>
#include <memory>

#include <nlohmann/json.hpp>

#include "client/terminal/exit_codes.h"

namespace creepctl {

void add_version(CLI::App& app, int& exit_code) {
  CLI::App* command = app.add_subcommand("version", "Prints the version");
  auto json = std::make_shared<bool>(false);
  command->add_flag("--json", *json, "Print JSON");
  command->footer("Example:\n  creepctl version --json");
  command->callback([json, &exit_code] {
    if (*json) {
      const nlohmann::ordered_json value = {{"name", "creepctl"}, {"version", CREEP_VERSION}};
      std::printf("%s\n", value.dump().c_str());
    } else {
      std::printf("creepctl %s\n", CREEP_VERSION);
    }
    exit_code = kOk;
  });
}

}  // namespace creepctl
