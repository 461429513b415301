#include "client/commands/commands.h"

#include <cstdio>
#include <memory>

#include <nlohmann/json.hpp>

#include "client/terminal/exit_codes.h"
#include "core/folder/sample_log.h"
#include "core/run/self_test.h"
#include "core/state/checkpoint.h"
#include "core/state/program_version.h"

namespace creepctl {
namespace {

/// Of the widest instruction set here; all have the same one, or the program could not tell.
std::string arithmetic_of_this_machine() { return creep::arithmetic_id(""); }

void print_as_json() {
  const nlohmann::ordered_json value = {{"name", "creepctl"},
                                        {"version", std::string(creep::program_version())},
                                        {"checkpoint_format", creep::kCheckpointVersion},
                                        {"sample_log_format", creep::kSampleLogVersion},
                                        {"arithmetic_id", arithmetic_of_this_machine()}};
  std::printf("%s\n", value.dump().c_str());
}

void print() {
  std::printf("creepctl %s\n", std::string(creep::program_version()).c_str());
  std::printf("checkpoint format %u (reads 1 to %u)\n", creep::kCheckpointVersion, creep::kCheckpointVersion);
  std::printf("sample log format %u\n", static_cast<unsigned>(creep::kSampleLogVersion));
  std::printf("arithmetic %s\n", arithmetic_of_this_machine().c_str());
}

}  // namespace

void add_version(CLI::App& app, int& exit_code) {
  CLI::App* command = app.add_subcommand(
      "version",
      "Prints the version, the formats that this program writes and the arithmetic of this machine");
  auto json = std::make_shared<bool>(false);
  command->add_flag("--json", *json, "Print JSON");
  command->footer("Example:\n  creepctl version --json");
  command->callback([json, &exit_code] {
    *json ? print_as_json() : print();
    exit_code = kOk;
  });
}

}  // namespace creepctl
