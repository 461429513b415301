#include <array>

#include "core/experiment/fidelity.h"
#include "core/experiment/sections.h"
#include "core/experiment/table_reader.h"
#include "core/experiment/wording.h"

namespace creep {
namespace {

constexpr std::array<std::string_view, 3> kInertia = {"none", "fragments", "all"};
constexpr std::array kInertiaValues = {InertiaScaling::kNone, InertiaScaling::kFragments,
                                       InertiaScaling::kAll};
constexpr std::array<std::string_view, 2> kSnapshots = {"none", "per decade of age"};

constexpr std::size_t kPaper = 1;  // in fidelity_names()

/// fidelity = { error = 0.05 }: the cheapest that was measured to be as good.
std::size_t read_error(const DocumentNode& table, DiagnosticLog& log) {
  TableReader reader(table, "fidelity", log);
  std::optional<double> error;
  reader.number("error", 1e-6, 1.0, error);
  if (!reader.has("error")) reader.error(table.begin, "fidelity needs error, as in { error = 0.2 }");
  reader.finish();
  if (!error) return kPaper;
  if (const auto index = cheapest_fidelity(*error)) return *index;
  const std::size_t best = most_accurate_fidelity();
  reader.error(reader.position_of("error"), "no fidelity was measured to have an error of at most " +
                                                shortest(*error) + "; the smallest is " +
                                                shortest(fidelity_measure(best).error) + " (" +
                                                quoted(fidelity_names()[best]) + ")");
  return best;
}

/// fidelity = "balanced", or by its error: what all other keys override.
Numerics read_fidelity(TableReader& reader, DiagnosticLog& log) {
  const DocumentNode* node = reader.find("fidelity");
  if (node != nullptr && node->kind == DocumentNode::Kind::kTable) {
    return fidelity_numerics(read_error(*node, log));
  }
  return fidelity_numerics(reader.word("fidelity", fidelity_names()).value_or(kPaper));
}

/// A criterion that a fidelity may have switched on: a number, or "none".
void read_criterion(TableReader& reader, std::string_view key, double least, double most,
                    std::optional<double>& target) {
  constexpr std::array<std::string_view, 1> kNone = {"none"};
  if (!reader.is_string(key)) {
    reader.number(key, least, most, target);
  } else if (reader.word(key, kNone)) {
    target.reset();
  }
}

/// breakages_per_ageing = 8, or "adaptive" with its tolerance; else breakage_fraction.
void read_ageing(TableReader& reader, Numerics& numerics) {
  constexpr std::array<std::string_view, 1> kAdaptive = {"adaptive"};
  constexpr double kDefaultTolerance = 0.1;
  const bool counted = reader.has("breakages_per_ageing");
  bool adaptive = false;
  if (reader.is_string("breakages_per_ageing")) {
    adaptive = reader.word("breakages_per_ageing", kAdaptive).has_value();
  } else {
    reader.count("breakages_per_ageing", 1, 1'000'000, numerics.breakages_per_ageing);
  }
  reader.number("breakage_fraction", 1e-6, 1.0, numerics.breakage_fraction);
  if (reader.has("breakage_fraction")) {
    if (counted) {
      reader.warning(reader.position_of("breakage_fraction"),
                     "breakage_fraction is not used: breakages_per_ageing goes before it");
    } else {
      numerics.breakages_per_ageing.reset();
    }
  }
  std::optional<double> tolerance;
  reader.number("ageing_error_tolerance", 1e-3, 10.0, tolerance);
  if (adaptive) {
    numerics.breakages_per_ageing.reset();
    numerics.breakage_fraction = kPaperBreakageFraction;
    numerics.ageing_error_tolerance = tolerance.value_or(kDefaultTolerance);
  } else if (tolerance) {
    reader.error(reader.position_of("ageing_error_tolerance"),
                 "ageing_error_tolerance needs breakages_per_ageing = \"adaptive\"");
  }
}

}  // namespace

Numerics read_numerics(const DocumentNode& table, DiagnosticLog& log) {
  TableReader reader(table, "[numerics]", log);
  Numerics numerics = read_fidelity(reader, log);
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
  read_criterion(reader, "drift_tolerance", 1e-4, 10.0, numerics.drift_tolerance);
  read_criterion(reader, "inertial_number_limit", 1e-6, 0.1, numerics.inertial_number_limit);
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
