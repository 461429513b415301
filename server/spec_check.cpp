#include "server/spec_check.h"

#include <cmath>
#include <numbers>

#include "absl/strings/str_cat.h"
#include "core/experiment/experiment_toml.h"
#include "core/physics/grading.h"
#include "server/refusal.h"

namespace creepd {
namespace {

/// Particles at the start.
double particle_count(const creep::SpecimenSpec& specimen) {
  if (specimen.particles) return static_cast<double>(*specimen.particles);
  const double volume = std::pow(specimen.side.value_or(0.0), 3) / (1.0 + specimen.void_ratio);
  return volume / (std::numbers::pi / 6.0 * creep::mean_cubed_diameter(specimen.grading));
}

/// The program itself, and for each particle its state, its neighbours, a checkpoint of both in the making
/// and its fragments. Measured at their highest: 10 MB, and 0.8 KiB a particle while 46 000 are packed, 2.6
/// KiB where 11 500 have been crushed to 25 000; the rest is for specimens that crush more.
std::uint64_t memory_for(double particles) {
  constexpr double kProgram = 48.0 * 1024 * 1024;
  constexpr double kEachParticle = 8.0 * 1024;
  return static_cast<std::uint64_t>(kProgram + kEachParticle * particles);
}

absl::Status invalid(std::vector<Violation> violations) {
  const std::string first = absl::StrCat(violations.front().field, ": ", violations.front().description);
  const std::string more =
      violations.size() > 1 ? absl::StrCat(" (and ", violations.size() - 1, " more)") : "";
  return refuse(absl::StatusCode::kInvalidArgument, absl::StrCat("the job file is wrong: ", first, more),
                {"INVALID_SPEC", {}, std::move(violations), {}});
}

std::string place_of(int line, int column) { return absl::StrCat("spec:", line, ":", column); }

}  // namespace

absl::StatusOr<CheckedSpec> check_spec(std::string_view text) {
  if (text.size() > kMostSpecBytes) {
    return invalid({{"spec", absl::StrCat(text.size(), " bytes; at most ", kMostSpecBytes, " are taken")}});
  }
  if (const auto file = creep::find_grading_file(text)) {
    return invalid(
        {{place_of(file->value_position.line, file->value_position.column),
          "the daemon opens no files: give the grading as points (creepctl submit puts them in)"}});
  }
  const creep::ParseResult parsed = creep::parse_experiment(text);
  std::vector<Violation> violations;
  for (const creep::Diagnostic& error : parsed.errors) {
    violations.push_back({place_of(error.line, error.column), error.message});
  }
  if (!violations.empty()) return invalid(std::move(violations));
  const double particles = particle_count(parsed.experiment->specimen);
  if (particles > static_cast<double>(kMostParticles)) {
    return invalid({{"spec", absl::StrCat("about ", static_cast<std::int64_t>(particles),
                                          " particles; at most ", kMostParticles, " are taken")}});
  }
  CheckedSpec checked;
  checked.name = parsed.experiment->name;
  checked.experiment_hash = creep::experiment_hash(*parsed.experiment);
  checked.specimen_hash = creep::specimen_hash(*parsed.experiment);
  checked.start = parsed.experiment->start;
  checked.memory_estimate = memory_for(particles);
  for (const creep::Diagnostic& warning : parsed.warnings) {
    checked.warnings.push_back(absl::StrCat(warning.line, ":", warning.column, ": ", warning.message));
  }
  return checked;
}

}  // namespace creepd
