#include "server/worker/summary_file.h"

#include <nlohmann/json.hpp>

#include "core/experiment/numerics_text.h"
#include "core/folder/durable_file.h"
#include "core/folder/sample_log.h"
#include "core/run/self_test.h"
#include "core/state/checkpoint.h"
#include "core/state/program_version.h"

namespace creepd {

absl::Status write_summary(const std::filesystem::path& path, const creep::Run& run,
                           const creep::Ending& ending, const SummaryFacts& facts) {
  nlohmann::ordered_json figures = nlohmann::ordered_json::object();
  for (const creep::SummaryFigure& figure : run.summary()) figures[figure.name] = figure.value;
  nlohmann::ordered_json numerics = nlohmann::ordered_json::object();
  for (const creep::NumericsValue& at : creep::numerics_values(facts.numerics)) {
    numerics[std::string(at.key)] = nlohmann::ordered_json::parse(at.value);
  }
  const double seconds = facts.total.wall_seconds;
  const nlohmann::ordered_json summary = {
      {"outcome", ending.outcome},
      {"reason", ending.reason},
      {"figures", figures},
      {"state_digest", run.state_digest()},
      {"experiment_hash", facts.experiment_hash},
      {"numerics", numerics},
      {"arithmetic_id", creep::arithmetic_id(facts.instruction_set)},
      {"inexact", run.inexact()},
      {"records", run.next_sequence()},
      {"warnings", run.warnings()},
      {"particle_steps_per_second", seconds > 0.0 ? facts.total.particle_steps / seconds : 0.0},
      {"wall_seconds", seconds},
      {"attempts", facts.attempts},
      {"threads", facts.threads},
      {"instruction_set", facts.instruction_set},
      {"versions",
       {{"creep_worker", std::string(creep::program_version())},
        {"checkpoint_format", creep::kCheckpointVersion},
        {"sample_log_format", creep::kSampleLogVersion},
        {"compiler", "g++ " __VERSION__}}}};
  return creep::write_durably(path,
                              summary.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + "\n");
}

}  // namespace creepd
