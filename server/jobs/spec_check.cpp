#include "server/jobs/spec_check.h"

#include "absl/strings/str_cat.h"
#include "core/experiment/experiment_toml.h"
#include "core/physics/particle_count.h"
#include "server/rules/refusal.h"

namespace creepd {
namespace {

/// Highest resident memory: the program itself; and for each particle its state, its neighbours, a checkpoint
/// of both in the making and read back, and pictures of both where they are taken. Measured a particle
/// present: up to 1.8 KiB, with pictures 2.4 KiB. The count of particles errs on the safe side, not this.
std::uint64_t memory_for(const creep::Experiment& experiment) {
  constexpr double kProgram = 12.0 * 1024 * 1024;
  constexpr double kEachParticle = 1.8 * 1024;
  constexpr double kEachPicture = 0.6 * 1024;
  const double each = kEachParticle + (experiment.output.snapshots_per_decade ? kEachPicture : 0.0);
  return static_cast<std::uint64_t>(kProgram + each * creep::crushed_particle_count(experiment));
}

absl::Status invalid(std::vector<Violation> violations, std::size_t left_out = 0) {
  const std::string first = absl::StrCat(violations.front().field, ": ", violations.front().description);
  const std::size_t others = violations.size() - 1 + left_out;
  const std::string more = others > 0 ? absl::StrCat(" (and ", others, " more)") : "";
  return refuse(absl::StatusCode::kInvalidArgument, absl::StrCat("the job file is wrong: ", first, more),
                {"INVALID_SPEC", {}, std::move(violations), {}, left_out});
}

Violation at(int line, int column, std::string_view what) {
  return {absl::StrCat("spec:", line, ":", column), std::string(what), line, column};
}

}  // namespace

absl::StatusOr<CheckedSpec> check_spec(std::string_view text) {
  if (text.size() > kMostSpecBytes) {
    return invalid({{"spec", absl::StrCat(text.size(), " bytes; at most ", kMostSpecBytes, " are taken")}});
  }
  if (const auto file = creep::find_grading_file(text)) {
    return invalid(
        {at(file->value_position.line, file->value_position.column,
            "the daemon opens no files: give the grading as points (creepctl submit puts them in)")});
  }
  const creep::ParseResult parsed = creep::parse_experiment(text);
  std::vector<Violation> violations;
  for (const creep::Diagnostic& error : parsed.errors) {
    violations.push_back(at(error.line, error.column, error.message));
  }
  if (parsed.more_errors > 0) violations.pop_back();
  if (!violations.empty()) return invalid(std::move(violations), parsed.more_errors);
  const double particles = creep::initial_particle_count(parsed.experiment->specimen);
  if (particles > static_cast<double>(kMostParticles)) {
    return invalid({{"spec", absl::StrCat("about ", static_cast<std::int64_t>(particles),
                                          " particles; at most ", kMostParticles, " are taken")}});
  }
  CheckedSpec checked;
  checked.name = parsed.experiment->name;
  checked.experiment_hash = creep::experiment_hash(*parsed.experiment);
  checked.specimen_hash = creep::specimen_hash(*parsed.experiment);
  checked.start = parsed.experiment->start;
  checked.memory_estimate = memory_for(*parsed.experiment);
  for (const creep::Diagnostic& warning : parsed.warnings) {
    checked.warnings.push_back(absl::StrCat(warning.line, ":", warning.column, ": ", warning.message));
  }
  return checked;
}

}  // namespace creepd
