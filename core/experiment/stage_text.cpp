#include "core/experiment/stage_text.h"

#include <cstdio>

#include "absl/strings/str_cat.h"
#include "core/experiment/units.h"
#include "core/experiment/wording.h"

namespace creep {
namespace {

std::string rounded(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.6g", value);
  return text;
}

}  // namespace

std::string target_text(const Target& target) {
  const auto stress = [&] { return format_quantity(target.value, Dimension::kStress); };
  switch (target.measure) {
    case Target::Measure::kAxialStress:
      return stress();
    case Target::Measure::kMeanStress:
      return "p = " + stress();
    case Target::Measure::kDeviatoricStress:
      return "q = " + stress();
    case Target::Measure::kStressRatio:
      return "q/p = " + rounded(target.value);
    case Target::Measure::kAxialStrain:
      return rounded(100.0 * target.value) + " % axial strain";
    case Target::Measure::kDeviatoricStrain:
      return rounded(100.0 * target.value) + " % deviatoric strain";
  }
  return "";
}

std::string stage_text(const Stage& stage) {
  std::string text(stage_name(stage));
  if (const Target* until = target_of(stage)) text += " to " + target_text(*until);
  if (const auto duration = duration_of(stage)) {
    text += " for " + format_quantity(*duration, Dimension::kDuration);
  }
  if (const auto* triaxial = std::get_if<TriaxialStage>(&stage); triaxial && triaxial->radial_stress) {
    text += " at radial " + format_quantity(*triaxial->radial_stress, Dimension::kStress);
  }
  if (const auto* creep = std::get_if<CreepStage>(&stage)) {
    if (creep->axial_stress) text += " at " + format_quantity(*creep->axial_stress, Dimension::kStress);
    if (creep->deviatoric_stress) {
      text += " at " + target_text({*creep->deviatoric_stress, Target::Measure::kDeviatoricStress});
    }
  }
  return text;
}

std::string kept_checkpoint_name(std::size_t place, const Stage& stage,
                                 std::optional<std::int64_t> multiple) {
  const absl::Dec number(place + 1, absl::kZeroPad2);
  std::string name = absl::StrCat(number, "_", std::string(stage_name(stage)), "_");
  if (!multiple) return name + "end";
  const Keep& keep = *keep_of(stage);
  const bool strain = keep.measure == Target::Measure::kAxialStrain;
  const double value = static_cast<double>(*multiple) * keep.step;
  absl::StrAppend(&name, std::string(measure_name(keep.measure)), "_", strain ? value : 1e-6 * value,
                  strain ? "" : "MPa");
  return name;
}

}  // namespace creep
