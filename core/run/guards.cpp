#include "core/run/guards.h"

#include <cmath>
#include <utility>

#include "absl/strings/str_cat.h"
#include "core/dem/measures.h"

namespace creep {
namespace {

constexpr double kLargestOverlap = 1.0;  // of the smaller radius: its centre reaches the surface of the other
/// Step over its bound. Beyond sqrt2 even one particle between fixed neighbours is unstable; stiffness may
/// rise that far and further for the few cycles until the step is evaluated again, which is no harm.
constexpr double kLargestStepRatio = 3.0;
/// Energy that nobody put in, over what walls did and was stored before: sound runs have 4e-4 and less.
constexpr double kLargestEnergyGrowth = 0.05;
/// Of the target, by a wall that had reached it: stress peaks of collapsing grains stay far below a tenfold.
constexpr double kLargestOvershoot = 9.0;
constexpr double kLargestInertialNumber = 0.1;  // of loading: beyond it grains collide rather than bear
constexpr double kLargestLoadingStrain = 0.5;   // axial, before loading is given up

}  // namespace

Outcome guard_stop(const std::string& reason, std::string advice) {
  return {Outcome::Kind::kGuardStop, absl::StrCat("guard ", reason), std::move(advice)};
}

std::optional<Outcome> cycle_guard(const CycleResult& result) {
  if (!result.finite) {
    return guard_stop("non-finite: a position, velocity or force is no longer a number",
                      "lower time_step_safety; the last good checkpoint is kept");
  }
  if (result.largest_overlap_ratio > kLargestOverlap) {
    return guard_stop(
        absl::StrCat("overlap: ", result.largest_overlap_ratio, " of the smaller radius, limit ",
                     kLargestOverlap),
        "lower time_step_safety or loading_velocity, or check modulus and stress; the last good "
        "checkpoint is kept");
  }
  if (result.step_ratio > kLargestStepRatio) {
    return guard_stop(
        absl::StrCat("step: ", result.step_ratio, " times its bound, limit ", kLargestStepRatio),
        "lower time_step_safety or loading_velocity; the last good checkpoint is kept");
  }
  return std::nullopt;
}

std::optional<Outcome> energy_guard(const EnergyLedger& energy, double unexplained) {
  const double input = std::fabs(energy.wall_work) + energy.initial_stored + energy.initial_tangential;
  const double grown = -unexplained;
  if (!(grown > kLargestEnergyGrowth * input)) return std::nullopt;
  return guard_stop(absl::StrCat("energy: ", grown, " J came from nowhere, limit ", kLargestEnergyGrowth,
                                 " of the ", input, " J put in"),
                    "lower time_step_safety; the last good checkpoint is kept");
}

std::optional<Outcome> servo_guard(double off_target) {
  if (!(off_target > kLargestOvershoot)) return std::nullopt;
  return guard_stop(absl::StrCat("servo: a wall that was on target is off it by ", off_target,
                                 " of it, limit ", kLargestOvershoot),
                    "lower loading_velocity, which caps the walls, or time_step_safety; the last good "
                    "checkpoint is kept");
}

std::optional<Outcome> loading_guard(const Specimen& specimen, const Experiment& experiment,
                                     const Target& target) {
  const double inertia = inertial_number(specimen, experiment);
  if (inertia > kLargestInertialNumber) {
    return guard_stop(
        absl::StrCat("inertia: inertial number ", inertia, " in loading, limit ", kLargestInertialNumber),
        "lower loading_velocity or axial_velocity");
  }
  if (axial_strain(specimen) <= kLargestLoadingStrain) return std::nullopt;
  return guard_stop(
      absl::StrCat("loading: axial strain ", kLargestLoadingStrain, " passed at ", specimen.walls.stress(2),
                   " Pa axial stress, ", value_of(Target::Measure::kDeviatoricStress, specimen),
                   " Pa deviatoric, target ", target.value),
      "the specimen is too weak for this target: ask for less, or check limit_stress, d0 and the "
      "size exponent");
}

std::optional<Outcome> stress_guard(const std::string& where, const Specimen& specimen,
                                    const ContactStress& carried, double gap, double tolerance) {
  if (gap < tolerance) return std::nullopt;
  return guard_stop(
      absl::StrCat("stress: ", where, " ends with ", specimen.walls.stress(2), " Pa axial and ",
                   radial_stress(specimen.walls), " Pa radial stress at the walls, but contacts that carry ",
                   carried.axial, " and ", carried.radial, " Pa (apart by ", gap, ", limit ", tolerance, ")"),
      "a specimen at rest has one stress: raise minimum_cycles or lower unbalanced_tolerance; grains of some "
      "millimetres under high stress bear forces beyond what is summed at walls");
}

Outcome settling_stop(const std::string& where, const Calm& calm, const Specimen& specimen) {
  return guard_stop(
      absl::StrCat("settling: ", where, " not in equilibrium after ", calm.cycle,
                   " cycles (unbalanced force ratio ", specimen.unbalanced_force_ratio,
                   ", last off target or breaking ", calm.cycle - calm.quiet_since, " cycles ago)"),
      "raise minimum_cycles, or loosen unbalanced_tolerance or settle_tolerance");
}

}  // namespace creep
