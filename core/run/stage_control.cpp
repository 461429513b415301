#include "core/run/stage_control.h"

#include <algorithm>
#include <cmath>
#include <variant>

#include "core/dem/measures.h"

namespace creep {
namespace {

using Measure = Target::Measure;
using Mode = AxisControl::Mode;

constexpr double kSampleStressRatio = 1.05;  // between samples of loading: even steps of log stress
constexpr double kSampleStrain = 0.002;      // the same of loading by strain

/// One function a kind of stage. A kind that is forgotten does not compile.
template <class... Function>
struct OfEach : Function... {
  using Function::operator()...;
};
template <class... Function>
OfEach(Function...) -> OfEach<Function...>;

bool is_strain(Measure measure) {
  return measure == Measure::kAxialStrain || measure == Measure::kDeviatoricStrain;
}

/// From now on the sides hold a stress: the one asked for, else the one held before, else the one reached.
void hold_sides(Aim& aim, const Specimen& specimen, std::optional<double> stress) {
  if (stress) {
    aim.radial = *stress;
  } else if (aim.sides == Aim::Sides::kFixed) {
    aim.radial = radial_stress(specimen.walls);
  }
  aim.sides = Aim::Sides::kHeld;
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

/// Of the axial pair.
AxisControl axial_control(const Stage& stage, const Aim& aim, const Numerics& numerics) {
  const AxisControl servo{Mode::kServo, aim.axial, numerics.loading_velocity};
  return std::visit(
      OfEach{[&](const OedometricStage& oedometric) {
               return is_strain(oedometric.until.measure)
                          ? AxisControl{Mode::kVelocity, 0.0, numerics.loading_velocity}
                          : servo;
             },
             [&](const IsotropicStage&) { return servo; },
             [&](const TriaxialStage& triaxial) {
               return AxisControl{Mode::kVelocity, 0.0, triaxial.axial_velocity};
             },
             [&](const UnloadStage&) { return servo; }, [&](const CreepStage&) { return servo; },
             [&](const RelaxationStage&) { return AxisControl{}; }},
      stage);
}

/// Most closing speed of sides that hold a stress [m/s].
double side_velocity(const Stage& stage, const Numerics& numerics) {
  const double usual = numerics.loading_velocity;
  return std::visit(
      OfEach{[&](const OedometricStage&) { return usual; }, [&](const IsotropicStage&) { return usual; },
             // At constant volume one pair alone has to open about as fast as the axis closes;
             // as much again for dilation and for a specimen that is wider than high.
             [&](const TriaxialStage& triaxial) { return std::max(usual, 2.0 * triaxial.axial_velocity); },
             [&](const UnloadStage&) { return usual; }, [&](const CreepStage&) { return usual; },
             [&](const RelaxationStage&) { return usual; }},
      stage);
}

}  // namespace

double closing_velocity_at(double limit, const Specimen& specimen, const Experiment& experiment) {
  const Walls& walls = specimen.walls;
  const double p = std::max((walls.stress(0) + walls.stress(1) + walls.stress(2)) / 3.0,
                            experiment.specimen.isotropic_stress);
  return limit * walls.length(2) / median_diameter(experiment.specimen.grading) *
         std::sqrt(p / experiment.material.density);
}

void take_aim(Aim& aim, const Stage& stage, const Specimen& specimen) {
  std::visit(OfEach{[&](const OedometricStage& oedometric) {
                      aim.sides = Aim::Sides::kFixed;
                      if (oedometric.until.measure == Measure::kAxialStress) {
                        aim.axial = oedometric.until.value;
                      }
                    },
                    [&](const IsotropicStage& isotropic) {
                      hold_sides(aim, specimen, isotropic.until.value);
                      aim.axial = isotropic.until.value;
                    },
                    [&](const TriaxialStage& triaxial) { hold_sides(aim, specimen, triaxial.radial_stress); },
                    [&](const UnloadStage& unload) {
                      const bool all = unload.until.measure == Measure::kMeanStress;
                      if (all) hold_sides(aim, specimen, unload.until.value);
                      if (unload.until.measure == Measure::kDeviatoricStress) hold_sides(aim, specimen, {});
                      aim.axial = axial_stress_of(unload.until, aim.radial);
                    },
                    [&](const CreepStage& creep) {
                      if (creep.axial_stress) aim.axial = *creep.axial_stress;
                      if (creep.deviatoric_stress) {
                        hold_sides(aim, specimen, {});
                        aim.axial = aim.radial + *creep.deviatoric_stress;
                      }
                    },
                    [&](const RelaxationStage&) { aim.axial = specimen.walls.stress(2); }},
             stage);
}

WallControl wall_control(const Stage& stage, const Aim& aim, const Numerics& numerics) {
  WallControl control{};
  if (aim.sides == Aim::Sides::kHeld) {
    const Target* until = target_of(stage);
    const bool follows = until == nullptr || until->measure != Measure::kMeanStress;
    control[0] = control[1] = {Mode::kServo, aim.radial, side_velocity(stage, numerics), follows};
  }
  control[2] = axial_control(stage, aim, numerics);
  return control;
}

bool comes_to_rest(const Stage& stage) {
  const auto by_mean_stress = [](const auto& loading) {
    return loading.until.measure == Measure::kMeanStress;
  };
  return std::visit(OfEach{[&](const OedometricStage& oedometric) { return by_mean_stress(oedometric); },
                           [&](const IsotropicStage& isotropic) { return by_mean_stress(isotropic); },
                           [&](const TriaxialStage& triaxial) { return by_mean_stress(triaxial); },
                           [](const UnloadStage&) { return true; }, [](const CreepStage&) { return false; },
                           [](const RelaxationStage&) { return false; }},
                    stage);
}

bool holds_strain(const Stage& stage) { return std::holds_alternative<RelaxationStage>(stage); }

bool has_peak(const Stage& stage) { return std::holds_alternative<TriaxialStage>(stage); }

bool has_passed(const Stage& stage, const Aim& aim, const Specimen& specimen, double tolerance) {
  const Target& until = *target_of(stage);
  if (std::holds_alternative<OedometricStage>(stage) && until.measure == Measure::kAxialStress) {
    return specimen.walls.stress(2) >= (1.0 - tolerance) * aim.axial;
  }
  return value_of(until.measure, specimen) >= until.value;
}

double off_target(const Stage& stage, const Aim& aim, const Specimen& specimen) {
  double largest = 0.0;
  const auto see = [&](std::size_t axis, double target) {
    largest = std::max(largest, std::fabs(specimen.walls.stress(axis) / target - 1.0));
  };
  if (!holds_strain(stage)) see(2, aim.axial);
  if (aim.sides == Aim::Sides::kHeld) {
    see(0, aim.radial);
    see(1, aim.radial);
  }
  return largest;
}

void keep_aim(Aim& aim, const Stage& stage, const Specimen& specimen) {
  const Target& until = *target_of(stage);
  if (is_strain(until.measure)) {
    aim.axial = specimen.walls.stress(2);
  } else if (std::holds_alternative<TriaxialStage>(stage)) {
    aim.axial = axial_stress_of(until, aim.radial);
  }
}

bool sample_is_due(std::optional<double>& next, const Stage& stage, const Specimen& specimen) {
  const double stress = specimen.walls.stress(2), strain = axial_strain(specimen);
  const auto rising = [&](double now, double after) {
    if (next && now < *next) return false;
    next = after;
    return true;
  };
  const auto by_stress = [&] { return rising(stress, kSampleStressRatio * stress); };
  return std::visit(OfEach{[&](const OedometricStage&) { return by_stress(); },
                           [&](const IsotropicStage&) { return by_stress(); },
                           [&](const TriaxialStage&) { return rising(strain, strain + kSampleStrain); },
                           [&](const UnloadStage&) {
                             if (next && stress > *next) return false;
                             next = stress / kSampleStressRatio;
                             return true;
                           },
                           [&](const CreepStage&) { return by_stress(); },
                           [&](const RelaxationStage&) { return by_stress(); }},
                    stage);
}

std::int64_t steps_passed(const Stage& stage, const Specimen& specimen) {
  const std::optional<Keep>& keep = keep_of(stage);
  if (!keep || keep->step == 0.0) return 0;
  const double steps = value_of(keep->measure, specimen) / keep->step;
  return static_cast<std::int64_t>(std::holds_alternative<UnloadStage>(stage) ? std::ceil(steps)
                                                                              : std::floor(steps));
}

bool goes_beyond(const Stage& stage, std::int64_t passed, std::int64_t kept) {
  return std::holds_alternative<UnloadStage>(stage) ? passed < kept : passed > kept;
}

}  // namespace creep
