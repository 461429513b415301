// Face-centred cubic packings of equal spheres: stiffness and largest stable step of the endless lattice,
// strength of a block between the product's walls.
#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "core/dem/dynamics.h"
#include "tests/core/dem_scenes.h"
#include "tests/validation/fcc_lattice.h"
#include "tests/validation/known_answers.h"

namespace creep {
namespace {

using testing::widest_kernels;
using validation::FccLattice;
using validation::KnownAnswers;

constexpr double kRadius = 0.105e-3;

Material quartz(bool rough) {
  Material material;
  if (!rough) material.roughness = 0.0;
  return material;
}

/// Overlap at which a contact carries a force [m].
double overlap_under(const ContactModel& model, double root_radius, double force) {
  double low = 0.0, high = 1e-4;
  for (int halving = 0; halving < 200; ++halving) {
    const double middle = 0.5 * (low + high);
    (model.modulus * root_radius * model.law.g(middle) < force ? low : high) = middle;
  }
  return high;
}

/// Isotropic stress p presses each contact with sqrt2 R^2 p, R half the distance of two centres.
struct Pressed {
  Pressed(const Material& material, double pressure) : model(material) {
    const double root = std::sqrt(0.5 * kRadius);
    for (int pass = 0; pass < 100; ++pass) {  // the distance depends on the overlap a little
      const double half = kRadius - 0.5 * overlap;
      force = std::sqrt(2.0) * half * half * pressure;
      overlap = overlap_under(model, root, force);
    }
    normal_stiffness = model.modulus * root * model.law.slope(overlap);
    tangential_stiffness = model.tangential_ratio * normal_stiffness;
    spacing = 2.0 * kRadius - overlap;
  }
  ContactModel model;
  double overlap = 0.0, force = 0.0, spacing = 0.0, normal_stiffness = 0.0, tangential_stiffness = 0.0;
};

Eigen::Matrix3d component(Eigen::Index row, Eigen::Index column, double size) {
  Eigen::Matrix3d tensor = Eigen::Matrix3d::Zero();
  tensor(row, column) = tensor(column, row) = size;
  return tensor;
}

/// d stress / d strain, by central difference from a fresh lattice.
Eigen::Matrix3d slope(const Pressed& pressed, const Eigen::Matrix3d& direction) {
  constexpr double kStrain = 1e-7;
  Eigen::Matrix3d end[2];
  for (const int side : {0, 1}) {
    FccLattice lattice(pressed.model, widest_kernels(), kRadius, pressed.overlap);
    lattice.strain((side == 1 ? kStrain : -kStrain) * direction);
    end[side] = lattice.stress();
  }
  return (end[1] - end[0]) / (2.0 * kStrain);
}

TEST(Fcc, has_the_stiffness_of_its_contacts) {
  KnownAnswers answers(
      "FCC stiffness C11, C12, C44 and stress, smooth and rough, 0.1 to 10 MPa", 1e-6,
      "central difference over a strain of 1e-7: rounding 1e-12 of an overlap over 1e-5 of it");
  for (const bool rough : {false, true}) {
    for (const double pressure : {0.1e6, 1e6, 10e6}) {
      const Pressed pressed(quartz(rough), pressure);
      const double kn = pressed.normal_stiffness, half = 0.5 * pressed.spacing;
      // Turning a contact by an angle moves its force sideways: kt acts as kt - F / distance. Of second order
      // in the overlap; without it these are the textbook formulas.
      const double kt = pressed.tangential_stiffness - pressed.force / pressed.spacing;
      const Eigen::Matrix3d axial = slope(pressed, component(2, 2, 1.0));
      const std::string name = (rough ? "rough, " : "smooth, ") + std::to_string(pressure) + " Pa: ";
      answers.relative(axial(2, 2), (kn + kt) / (std::sqrt(2.0) * half), name + "C11");
      answers.relative(axial(0, 0), (kn - kt) / (2.0 * std::sqrt(2.0) * half) + pressure, name + "C12");
      answers.relative(axial(1, 1), (kn - kt) / (2.0 * std::sqrt(2.0) * half) + pressure, name + "C12");
      const Eigen::Matrix3d shear = slope(pressed, component(0, 2, 0.5));
      answers.relative(shear(0, 2), (kn + kt) / (2.0 * std::sqrt(2.0) * half) - 0.5 * pressure, name + "C44");
      FccLattice lattice(pressed.model, widest_kernels(), kRadius, pressed.overlap);
      const Eigen::Matrix3d stress = lattice.stress();
      answers.relative(stress(0, 0), pressure, name + "stress");
      answers.relative(stress(2, 2), pressure, name + "stress");
      EXPECT_LT(std::fabs(stress(0, 2)), 1e-9 * pressure);
    }
  }
}

TEST(Fcc, has_the_stiffness_that_others_computed) {
  KnownAnswers answers(
      "FCC C11 of 0.21 mm quartz spheres, numbers computed beforehand, smooth and rough, 0.1 and 1 MPa", 0.01,
      "they take the undeformed distance: overlap / 2R, up to 1 % for rough grains at 1 MPa");
  struct Known {
    bool rough;
    double pressure, c11;
  };
  for (const Known& known : {Known{false, 0.1e6, 1.1679e9},
                             {false, 1e6, 2.5163e9},
                             {true, 0.1e6, 0.35164e9},
                             {true, 1e6, 1.0304e9}}) {
    const Pressed pressed(quartz(known.rough), known.pressure);
    answers.relative(slope(pressed, component(0, 0, 1.0))(0, 0), known.c11, known.rough ? "rough" : "smooth");
  }
}

/// How many times the kinetic energy grows over a thousand steps after a push.
double growth(const Pressed& pressed, double step) {
  FccLattice lattice(pressed.model, widest_kernels(), kRadius, pressed.overlap);
  // Unlike velocities excite every mode of the cell, the stiffest (layers against each other) among them.
  lattice.set_velocity(0, {1e-12, -2e-12, 0.5e-12});
  lattice.set_velocity(1, {-1e-12, 0.7e-12, 1.5e-12});
  lattice.set_velocity(2, {0.3e-12, 1e-12, -2e-12});
  const double brought = lattice.kinetic_energy();
  double largest = 0.0;
  for (int k = 0; k < 1000; ++k) {
    lattice.move(step);
    largest = std::max(largest, lattice.kinetic_energy());
  }
  return largest / brought;
}

TEST(Fcc, is_stable_up_to_the_step_of_its_stiffest_mode_and_not_beyond) {
  KnownAnswers answers("FCC largest stable step, from the growth of small motions: 0.5137 sqrt(m/kn)", 2e-3,
                       "bracketed within 0.2 %; geometric stiffness, F / distance, is 1e-4 of kn");
  const Pressed pressed(quartz(false), 0.1e6);
  ASSERT_NEAR(pressed.model.tangential_ratio, 0.895, 1e-3);
  const double unit = 1.0 / std::sqrt(pressed.normal_stiffness);  // spheres of the lattice have unit mass
  // A stable mode a thousandth below its limit stores 500 times the energy that it was given.
  constexpr double kUnbounded = 1e4;
  double low = 0.4, high = 0.7;
  ASSERT_LT(growth(pressed, low * unit), kUnbounded);
  ASSERT_GT(growth(pressed, high * unit), kUnbounded);
  while (high - low > 0.001) {
    const double middle = 0.5 * (low + high);
    (growth(pressed, middle * unit) < kUnbounded ? low : high) = middle;
  }
  // Neighbouring layers against each other, along their normal: omega^2 = 8 (kn + kt) / m.
  const double known = 2.0 / std::sqrt(8.0 * (1.0 + pressed.model.tangential_ratio));
  EXPECT_NEAR(known, 0.5137, 5e-5);
  answers.relative(0.5 * (low + high), known, "stable step");
}

/// Largest ratio of axial to lateral stress while the lattice is compressed along z at constant lateral
/// stress.
double strength(double friction, double pressure) {
  const Pressed pressed(quartz(false), pressure);
  FccLattice lattice(pressed.model, widest_kernels(), kRadius, pressed.overlap, friction);
  const double elastic = pressed.overlap / pressed.spacing;
  constexpr double kIncrements = 200.0;  // in the elastic range
  const auto deform = [&](double axial, double lateral) {
    FccLattice trial = lattice;
    Eigen::Matrix3d by = component(2, 2, axial);
    by(0, 0) = by(1, 1) = lateral;
    trial.strain(by);
    return trial;
  };
  double largest = 0.0;
  for (int increment = 0; increment < 10 * kIncrements; ++increment) {
    const double axial = elastic / kIncrements;
    double low = -2.0 * axial, high = axial;  // lateral strain, expansion negative
    for (int halving = 0; halving < 40; ++halving) {
      const double middle = 0.5 * (low + high);
      (deform(axial, middle).stress()(0, 0) < pressure ? low : high) = middle;
    }
    lattice = deform(axial, 0.5 * (low + high));
    const Eigen::Matrix3d stress = lattice.stress();
    EXPECT_NEAR(stress(0, 0) / pressure, 1.0, 1e-6);
    largest = std::max(largest, 2.0 * stress(2, 2) / (stress(0, 0) + stress(1, 1)));
  }
  return largest;
}

TEST(Fcc, fails_at_thorntons_stress_ratio) {
  KnownAnswers rigid("FCC strength 2 (1 + mu) / (1 - mu), mu = 0 to 0.5, extrapolated to rigid spheres", 1e-7,
                     "the second order of the overlap, 1e-5 of the radius");
  KnownAnswers stiff("FCC strength at 1 kPa, overlap 1e-5 of the radius", 1e-4,
                     "the lattice deforms by some overlaps before it fails");
  for (const double friction : {0.0, 0.2, 0.275, 0.3, 0.5}) {
    const double known = 2.0 * (1.0 + friction) / (1.0 - friction);
    const double fine = strength(friction, 1e3), coarse = strength(friction, 8e3);
    stiff.relative(fine, known, "mu " + std::to_string(friction));
    // Overlaps go as pressure^(2/3), so the error of the second is four times that of the first.
    rigid.relative(fine + (fine - coarse) / 3.0, known, "mu " + std::to_string(friction));
  }
}

/// A block of equal spheres pressed together, faces along the walls. @param layers  odd, so that opposite
/// faces are alike.
Specimen block(const Experiment& experiment, const Pressed& pressed, int layers) {
  const double pitch = pressed.spacing / std::sqrt(2.0);  // of layers
  // A sphere of a face is held by four contacts.
  const double at_wall =
      overlap_under(pressed.model, std::sqrt(kRadius), 4.0 / std::sqrt(2.0) * pressed.force);
  const double margin = kRadius - at_wall;
  std::vector<testing::Ball> spheres;
  for (int x = 0; x < layers; ++x) {
    for (int y = 0; y < layers; ++y) {
      for (int z = 0; z < layers; ++z) {
        if ((x + y + z) % 2 != 0) continue;
        spheres.push_back({margin + x * pitch, margin + y * pitch, margin + z * pitch, kRadius});
      }
    }
  }
  return testing::balls(experiment, 2.0 * margin + (layers - 1) * pitch, spheres);
}

TEST(Fcc, a_block_between_the_walls_fails_at_the_same_ratio) {
  KnownAnswers answers("FCC strength, mu = 0.275: block of 63 spheres sheared between servo-controlled walls",
                       5e-4,
                       "overlap at 1 kPa as above; edges and corners are held by fewer contacts than faces");
  constexpr double kPressure = 1e3, kFriction = 0.275;
  constexpr int kLayers = 5;
  Experiment experiment;
  experiment.material = quartz(false);
  experiment.material.friction = kFriction;
  const Pressed pressed(experiment.material, kPressure);
  Dynamics dynamics(experiment, widest_kernels(), {});
  Specimen specimen = block(experiment, pressed, kLayers);
  dynamics.assess(specimen);
  const double speed = kLayers * pressed.overlap / (4000.0 * specimen.time_step);
  testing::run_cycles(specimen, experiment, dynamics, testing::isotropic(kPressure, 4.0 * speed), 10000);
  ASSERT_NEAR(specimen.walls.stress(2) / kPressure, 1.0, 1e-3);  // else the servo has not settled
  WallControl shear = testing::isotropic(kPressure, 4.0 * speed);
  shear[2] = {AxisControl::Mode::kVelocity, 0.0, speed};
  double largest = 0.0;
  for (int sample = 0; sample < 400; ++sample) {
    testing::run_cycles(specimen, experiment, dynamics, shear, 100);
    const auto force = [&](std::size_t axis) {
      return specimen.walls.force[2 * axis] + specimen.walls.force[2 * axis + 1];
    };
    largest = std::max(largest, 2.0 * force(2) / (force(0) + force(1)));
  }
  answers.relative(largest, 2.0 * (1.0 + kFriction) / (1.0 - kFriction), "largest stress ratio");
}

}  // namespace
}  // namespace creep
