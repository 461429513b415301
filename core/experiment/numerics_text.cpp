#include "core/experiment/numerics_text.h"

#include "core/experiment/units.h"
#include "core/experiment/wording.h"

namespace creep {
namespace {

std::string quantity(double value, Dimension dimension) { return quoted(format_quantity(value, dimension)); }

std::string_view inertia_word(InertiaScaling scaling) {
  switch (scaling) {
    case InertiaScaling::kNone:
      return "none";
    case InertiaScaling::kFragments:
      return "fragments";
    case InertiaScaling::kAll:
      return "all";
  }
  return "";
}

}  // namespace

std::vector<NumericsValue> numerics_values(const Numerics& numerics) {
  std::vector<NumericsValue> values;
  const auto add = [&](std::string_view key, std::string value) {
    values.push_back({key, std::move(value)});
  };
  add("fidelity", quoted(numerics.fidelity));
  add("minimum_cycles", std::to_string(numerics.minimum_cycles));
  add("time_step_safety", shortest(numerics.time_step_safety));
  if (numerics.ageing_error_tolerance) {
    add("breakages_per_ageing", quoted("adaptive"));
    add("ageing_error_tolerance", shortest(*numerics.ageing_error_tolerance));
  } else if (numerics.breakages_per_ageing) {
    add("breakages_per_ageing", std::to_string(*numerics.breakages_per_ageing));
  } else if (numerics.breakage_fraction != kPaperBreakageFraction) {
    add("breakage_fraction", shortest(numerics.breakage_fraction));
  }
  if (numerics.drift_tolerance) add("drift_tolerance", shortest(*numerics.drift_tolerance));
  if (numerics.inertial_number_limit) {
    add("inertial_number_limit", shortest(*numerics.inertial_number_limit));
  }
  add("settle_tolerance", shortest(numerics.settle_tolerance));
  add("unbalanced_tolerance", shortest(numerics.unbalanced_tolerance));
  add("local_damping", shortest(numerics.local_damping));
  add("inertia_scaling", quoted(inertia_word(numerics.inertia_scaling)));
  add("failure_check_interval", std::to_string(numerics.failure_check_interval));
  add("loading_velocity", quantity(numerics.loading_velocity, Dimension::kVelocity));
  if (numerics.skin) add("skin", quantity(*numerics.skin, Dimension::kLength));
  return values;
}

std::string numerics_text(const Numerics& numerics) {
  std::string text;
  for (const NumericsValue& value : numerics_values(numerics)) {
    text += (text.empty() ? "" : ", ") + std::string(value.key) + " = " + value.value;
  }
  return text;
}

}  // namespace creep
