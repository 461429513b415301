#include "core/physics/particle_count.h"

#include <algorithm>
#include <numbers>
#include <optional>
#include <variant>

#include "core/physics/grading.h"
#include "core/physics/strength.h"

namespace creep {
namespace {

constexpr double kOpenStress = 100e6;      // [Pa]
constexpr double kInheritedStress = 30e6;  // [Pa]
constexpr double kPeakStressRatio = 4.0;   // axial over radial stress of sand at its peak, and some more
constexpr double kFragmentsPerStress = 590.0;
constexpr double kMostPerParticle = 40.0;  // broken twice, all but the fragments below the comminution limit

/// Axial stress that a target means at a radial stress [Pa]; none if it leaves it open.
std::optional<double> axial_stress_of(const Target& target, double radial_stress) {
  switch (target.measure) {
    case Target::Measure::kAxialStress:
    case Target::Measure::kMeanStress:
      return target.value;
    case Target::Measure::kDeviatoricStress:
      return radial_stress + target.value;
    case Target::Measure::kStressRatio:
    case Target::Measure::kAxialStrain:
    case Target::Measure::kDeviatoricStrain:
      return std::nullopt;
  }
  return std::nullopt;
}

double highest_stress(const Experiment& experiment) {
  double highest = experiment.start ? kInheritedStress : experiment.specimen.isotropic_stress;
  double held = 0.0;  // on all sides, the last one [Pa]
  for (const Stage& stage : experiment.program) {
    if (const auto* isotropic = std::get_if<IsotropicStage>(&stage)) held = isotropic->until.value;
    if (const auto* triaxial = std::get_if<TriaxialStage>(&stage))
      held = triaxial->radial_stress.value_or(held);
    if (const auto* creep = std::get_if<CreepStage>(&stage)) {
      highest = std::max(highest, creep->axial_stress.value_or(0.0));
      highest = std::max(highest, held + creep->deviatoric_stress.value_or(0.0));
    } else if (const Target* target = target_of(stage)) {
      const double open = held > 0.0 ? kPeakStressRatio * held : kOpenStress;
      highest = std::max(highest, axial_stress_of(*target, held).value_or(open));
    }
  }
  return highest;
}

}  // namespace

double initial_particle_count(const SpecimenSpec& specimen) {
  if (specimen.particles) return static_cast<double>(*specimen.particles);
  if (!specimen.side) return 0.0;
  const double side = *specimen.side;
  const double volume = side * side * side / (1.0 + specimen.void_ratio);
  return volume / (std::numbers::pi / 6.0 * mean_cubed_diameter(specimen.grading));
}

double crushed_particle_count(const Experiment& experiment) {
  const SpecimenSpec& specimen = experiment.specimen;
  const double initial = initial_particle_count(specimen);
  if (experiment.material.comminution_limit > coarsest_diameter(specimen.grading)) return initial;
  const double strength = limit_stress(experiment.material, median_diameter(specimen.grading), 0.0);
  const double growth = 1.0 + kFragmentsPerStress * highest_stress(experiment) / strength;
  return initial * std::min(growth, kMostPerParticle);
}

}  // namespace creep
