#include <array>

#include "core/experiment/sections.h"
#include "core/experiment/table_reader.h"
#include "core/experiment/wording.h"

namespace creep {
namespace {

constexpr std::array<std::string_view, 4> kFidelities = {"paper", "reference", "balanced", "fast"};
constexpr std::array<std::string_view, 3> kInertia = {"none", "fragments", "all"};
constexpr std::array kInertiaValues = {InertiaScaling::kNone, InertiaScaling::kFragments,
                                       InertiaScaling::kAll};
constexpr std::array<std::string_view, 2> kSnapshots = {"none", "per decade of age"};

/// breakages_per_ageing = 8, or "adaptive" with its tolerance.
void read_ageing(TableReader& reader, Numerics& numerics) {
  constexpr std::array<std::string_view, 1> kAdaptive = {"adaptive"};
  constexpr double kDefaultTolerance = 0.1;
  bool adaptive = false;
  if (reader.is_string("breakages_per_ageing")) {
    adaptive = reader.word("breakages_per_ageing", kAdaptive).has_value();
  } else {
    reader.count("breakages_per_ageing", 1, 1'000'000, numerics.breakages_per_ageing);
  }
  std::optional<double> tolerance;
  reader.number("ageing_error_tolerance", 1e-3, 10.0, tolerance);
  if (adaptive) {
    numerics.ageing_error_tolerance = tolerance.value_or(kDefaultTolerance);
  } else if (tolerance) {
    reader.error(reader.position_of("ageing_error_tolerance"),
                 "ageing_error_tolerance needs breakages_per_ageing = \"adaptive\"");
  }
}

}  // namespace

Numerics read_numerics(const DocumentNode& table, DiagnosticLog& log) {
  TableReader reader(table, "[numerics]", log);
  Numerics numerics;
  if (const auto fidelity = reader.word("fidelity", kFidelities); fidelity && *fidelity > 0) {
    reader.error(reader.position_of("fidelity"),
                 "fidelity " + quoted(kFidelities[*fidelity]) +
                     " has not been measured yet; use \"paper\" and explicit keys");
  }
  reader.count("minimum_cycles", 10, 100'000'000, numerics.minimum_cycles);
  reader.number("time_step_safety", 0.01, 1.0, numerics.time_step_safety);
  read_ageing(reader, numerics);
  reader.number("settle_tolerance", 1e-6, 0.1, numerics.settle_tolerance);
  reader.number("unbalanced_tolerance", 1e-9, 0.1, numerics.unbalanced_tolerance);
  reader.number("local_damping", 0.0, 0.95, numerics.local_damping);
  if (const auto inertia = reader.word("inertia_scaling", kInertia)) {
    numerics.inertia_scaling = kInertiaValues[*inertia];
  }
  reader.count("failure_check_interval", 1, 10'000, numerics.failure_check_interval);
  reader.quantity("loading_velocity", Dimension::kVelocity, 1e-6, 10.0, numerics.loading_velocity);
  reader.number("drift_tolerance", 1e-4, 10.0, numerics.drift_tolerance);
  reader.number("inertial_number_limit", 1e-6, 0.1, numerics.inertial_number_limit);
  reader.quantity("skin", Dimension::kLength, 1e-9, 1e-2, numerics.skin);
  reader.finish();
  return numerics;
}

Output read_output(const DocumentNode& table, DiagnosticLog& log) {
  TableReader reader(table, "[output]", log);
  Output output;
  if (const auto snapshots = reader.word("snapshots", kSnapshots))
    output.snapshots_per_decade = *snapshots == 1;
  reader.finish();
  return output;
}

}  // namespace creep
