#include "client/commands/commands.h"

#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>

#include "client/job_file/job_file.h"
#include "client/terminal/exit_codes.h"
#include "core/experiment/numerics_text.h"
#include "core/experiment/stage_text.h"
#include "core/experiment/units.h"

namespace creepctl {
namespace {

using creep::Dimension;
using creep::format_quantity;

/// "3000 particles", or where the specimen comes from if the job leaves it to its source.
std::string specimen_text(const creep::Experiment& experiment) {
  const creep::SpecimenSpec& specimen = experiment.specimen;
  if (specimen.particles) return std::to_string(*specimen.particles) + " particles";
  if (specimen.side) return "a cube of " + format_quantity(*specimen.side, Dimension::kLength);
  return "the specimen of job " + experiment.start->job;
}

/// "3000 particles, oedometric to 21.7 MPa, creep for 2 d"
std::string summary(const creep::Experiment& experiment) {
  std::string text = specimen_text(experiment);
  for (const creep::Stage& stage : experiment.program) text += ", " + creep::stage_text(stage);
  return text;
}

nlohmann::ordered_json to_json(const std::vector<FileDiagnostic>& diagnostics) {
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  for (const FileDiagnostic& at : diagnostics) {
    list.push_back({{"file", at.file},
                    {"line", at.diagnostic.line},
                    {"column", at.diagnostic.column},
                    {"message", at.diagnostic.message}});
  }
  return list;
}

void print_json(const JobFile& job) {
  nlohmann::ordered_json value = {{"file", job.path},
                                  {"valid", job.experiment.has_value()},
                                  {"errors", to_json(job.errors)},
                                  {"warnings", to_json(job.warnings)}};
  if (job.experiment) {
    value["summary"] = summary(*job.experiment);
    value["experiment_hash"] = creep::experiment_hash(*job.experiment);
    value["numerics"] = nlohmann::ordered_json::object();
    for (const creep::NumericsValue& at : creep::numerics_values(job.experiment->numerics)) {
      value["numerics"][std::string(at.key)] = nlohmann::ordered_json::parse(at.value);
    }
  }
  // Bytes of a path or message that are no UTF-8 are replaced, not thrown at the user.
  std::printf("%s\n", value.dump(2, ' ', false, nlohmann::json::error_handler_t::replace).c_str());
}

int validate(const std::string& path, bool json) {
  const JobFile job = read_job_file(path);
  if (json) {
    print_json(job);
  } else {
    print_diagnostics(job);
    if (job.experiment) {
      std::printf("%s: valid: %s\n", path.c_str(), summary(*job.experiment).c_str());
      std::printf("%s: numerics: %s\n", path.c_str(), creep::numerics_text(job.experiment->numerics).c_str());
    }
  }
  return job.experiment ? kOk : kInvalidInput;
}

struct Options {
  std::string path;
  bool json = false;
};

}  // namespace

void add_validate(CLI::App& app, int& exit_code) {
  CLI::App* command =
      app.add_subcommand("validate", "Checks a job file and shows everything that is wrong with it");
  auto options = std::make_shared<Options>();
  command->add_option("JOB", options->path, "The job file")->required();
  command->add_flag("--json", options->json, "Print JSON on stdout");
  command->footer(
      "Exit code 0: valid; 5: not valid, or cannot be read.\n\n"
      "Example:\n  creepctl validate client/examples/oedometer_creep.toml");
  command->callback([options, &exit_code] { exit_code = validate(options->path, options->json); });
}

}  // namespace creepctl
