#include "core/run/stage_control.h"

#include <algorithm>
#include <cmath>

#include "core/dem/measures.h"

namespace creep {
namespace {

using Measure = Target::Measure;

bool is_strain(Measure measure) {
  return measure == Measure::kAxialStrain || measure == Measure::kDeviatoricStrain;
}

/// From now on the sides hold a stress: the one asked for, else the one held before, else the one reached.
void hold_sides(Cursor& cursor, const Specimen& specimen, std::optional<double> stress) {
  if (stress) {
    cursor.radial_target = *stress;
  } else if (cursor.sides == Cursor::Sides::kFixed) {
    cursor.radial_target = radial_stress(specimen.walls);
  }
  cursor.sides = Cursor::Sides::kHeld;
}

/// Axial stress of a target given as a stress, with the sides held.
double axial_stress_of(const Target& until, double radial) {
  switch (until.measure) {
    case Measure::kDeviatoricStress:
      return radial + until.value;
    case Measure::kStressRatio:  // q / p = x at constant s_r: q = 3 x s_r / (3 - x)
      return radial + 3.0 * until.value * radial / (3.0 - until.value);
    default:
      return until.value;
  }
}

}  // namespace

double closing_velocity_at(double limit, const Specimen& specimen, const Experiment& experiment) {
  const Walls& walls = specimen.walls;
  const double p = std::max((walls.stress(0) + walls.stress(1) + walls.stress(2)) / 3.0,
                            experiment.specimen.isotropic_stress);
  return limit * walls.length(2) / median_diameter(experiment.specimen.grading) *
         std::sqrt(p / experiment.material.density);
}

void take_aim(Cursor& cursor, const Stage& stage, const Specimen& specimen) {
  if (const auto* oedometric = std::get_if<OedometricStage>(&stage)) {
    cursor.sides = Cursor::Sides::kFixed;
    if (oedometric->until.measure == Measure::kAxialStress) cursor.target = oedometric->until.value;
  } else if (const auto* isotropic = std::get_if<IsotropicStage>(&stage)) {
    hold_sides(cursor, specimen, isotropic->until.value);
    cursor.target = isotropic->until.value;
  } else if (const auto* triaxial = std::get_if<TriaxialStage>(&stage)) {
    hold_sides(cursor, specimen, triaxial->radial_stress);
  } else if (const auto* unload = std::get_if<UnloadStage>(&stage)) {
    const bool all = unload->until.measure == Measure::kMeanStress;
    if (all) hold_sides(cursor, specimen, unload->until.value);
    if (unload->until.measure == Measure::kDeviatoricStress) hold_sides(cursor, specimen, {});
    cursor.target = axial_stress_of(unload->until, cursor.radial_target);
  } else if (const auto* creep = std::get_if<CreepStage>(&stage)) {
    if (creep->axial_stress) cursor.target = *creep->axial_stress;
    if (creep->deviatoric_stress) {
      hold_sides(cursor, specimen, {});
      cursor.target = cursor.radial_target + *creep->deviatoric_stress;
    }
  } else {
    cursor.target = specimen.walls.stress(2);
  }
}

WallControl wall_control(const Stage& stage, const Cursor& cursor, const Numerics& numerics) {
  using Mode = AxisControl::Mode;
  WallControl control{};
  const auto* triaxial = std::get_if<TriaxialStage>(&stage);
  if (cursor.sides == Cursor::Sides::kHeld) {
    // At constant volume one pair alone has to open about as fast as the axis closes; as much again for
    // dilation and for a specimen that is wider than high.
    const double cap = triaxial != nullptr
                           ? std::max(numerics.loading_velocity, 2.0 * triaxial->axial_velocity)
                           : numerics.loading_velocity;
    const Target* until = target_of(stage);
    const bool follows = until == nullptr || until->measure != Measure::kMeanStress;
    control[0] = control[1] = {Mode::kServo, cursor.radial_target, cap, follows};
  }
  if (triaxial != nullptr) {
    control[2] = {Mode::kVelocity, 0.0, triaxial->axial_velocity};
  } else if (const auto* oedometric = std::get_if<OedometricStage>(&stage);
             oedometric != nullptr && is_strain(oedometric->until.measure)) {
    control[2] = {Mode::kVelocity, 0.0, numerics.loading_velocity};
  } else if (!std::holds_alternative<RelaxationStage>(stage)) {
    control[2] = {Mode::kServo, cursor.target, numerics.loading_velocity};
  }
  return control;
}

bool comes_to_rest(const Stage& stage) {
  const Target* until = target_of(stage);
  return until != nullptr &&
         (until->measure == Measure::kMeanStress || std::holds_alternative<UnloadStage>(stage));
}

bool has_passed(const Stage& stage, const Cursor& cursor, const Specimen& specimen, double tolerance) {
  const Target& until = *target_of(stage);
  if (std::holds_alternative<OedometricStage>(stage) && until.measure == Measure::kAxialStress) {
    return specimen.walls.stress(2) >= (1.0 - tolerance) * cursor.target;
  }
  return value_of(until.measure, specimen) >= until.value;
}

double off_target(const Stage& stage, const Cursor& cursor, const Specimen& specimen) {
  double largest = 0.0;
  const auto see = [&](std::size_t axis, double target) {
    largest = std::max(largest, std::fabs(specimen.walls.stress(axis) / target - 1.0));
  };
  if (!std::holds_alternative<RelaxationStage>(stage)) see(2, cursor.target);
  if (cursor.sides == Cursor::Sides::kHeld) {
    see(0, cursor.radial_target);
    see(1, cursor.radial_target);
  }
  return largest;
}

void keep_aim(Cursor& cursor, const Stage& stage, const Specimen& specimen) {
  const Target& until = *target_of(stage);
  if (is_strain(until.measure)) {
    cursor.target = specimen.walls.stress(2);
  } else if (std::holds_alternative<TriaxialStage>(stage)) {
    cursor.target = axial_stress_of(until, cursor.radial_target);
  }
}

}  // namespace creep
