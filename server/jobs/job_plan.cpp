#include "server/jobs/job_plan.h"

#include "core/experiment/experiment_toml.h"
#include "core/folder/durable_file.h"
#include "server/jobs/spec_check.h"
#include "server/rules/refusal.h"

namespace creepd {

absl::StatusOr<std::string> pilot_spec(const std::string& spec) {
  if (const auto checked = check_spec(spec); !checked.ok()) return checked.status();
  auto text = creep::pilot_text(spec, *creep::parse_experiment(spec).experiment);
  if (text.ok()) return text;
  const std::string message(text.status().message());
  return refuse(absl::StatusCode::kInvalidArgument, message, {"BAD_REQUEST", {}, {{"spec", message}}, {}});
}

absl::StatusOr<JobPlan> read_job_plan(const std::string& spec, const std::filesystem::path& pilot_folder,
                                      const std::string& reason) {
  creep::PilotTables tables;
  tables.reason = reason;
  for (const auto& [name, text] :
       {std::pair("job.toml", &tables.job), std::pair("stages.csv", &tables.stages),
        std::pair("stage_timings.csv", &tables.timings)}) {
    auto read = creep::read_file(pilot_folder / name);
    if (!read.ok()) return read.status();
    *text = *std::move(read);
  }
  auto pilot = creep::read_pilot(tables);
  if (!pilot.ok()) return pilot.status();
  creep::Plan plan = creep::make_plan(*creep::parse_experiment(spec).experiment, *pilot);
  return JobPlan{std::move(plan), *std::move(pilot)};
}

}  // namespace creepd
