// Walls that hold a stress: the equation of the servo's header on an elastic specimen, and a sheared one.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "core/dem/servo.h"
#include "core/run/run.h"
#include "tests/core/run_scene.h"

namespace creep {
namespace {

/// A specimen that is a spring between the walls of the first axis, which has to spread at a speed.
struct Spring {
  static constexpr double kMass = 1e-5;                 // [kg]
  static constexpr double kStiffness = 1e6;             // [N/m] of the whole
  static constexpr double kSide = 2e-3;                 // [m]
  static constexpr double kDiameter = 0.2e-3;           // [m]
  static constexpr double kStress = 1e6;                // [Pa]
  static constexpr double kLag = 3.162277660168379e-6;  // T = sqrt(M/K) [s]

  explicit Spring(bool follows, ServoGains asked = {}, double cap = 10.0) : gains(asked) {
    for (std::size_t axis = 0; axis < 3; ++axis) walls.position[2 * axis + 1] = kSide;
    walls.stiffness.fill(kStiffness * kSide / kDiameter);
    walls.force.fill(kStress * kSide * kSide);
    control[0] = {AxisControl::Mode::kServo, kStress, cap, follows};
    force = walls.force[0];
  }

  /// `late`: time constant of a first-order answer of the force [s].
  void advance(double time, double spreading, double late = 0.0) {
    const double step = kLag / 1000.0;
    for (double passed = 0.0; passed < time; passed += step) {
      steer(walls, control, kMass, kDiameter, step, gains);
      force += 2.0 * kStiffness * (walls.velocity[0] + spreading) * step;
      const double shown = late > 0.0 ? walls.force[0] + (force - walls.force[0]) * step / late : force;
      walls.force[0] = walls.force[1] = shown;
    }
  }
  /// Force less the target [N].
  double excess() const { return walls.force[0] - kStress * kSide * kSide; }

  Walls walls;
  WallControl control{};
  ServoGains gains;
  double force;
};

constexpr double kSpreading = 0.05;  // of one wall [m/s]

TEST(Servo, in_proportion_alone_leaves_the_error_that_moves_the_walls) {
  Spring spring(false);
  spring.advance(100.0 * Spring::kLag, kSpreading);
  const double impedance = std::sqrt(Spring::kMass * Spring::kStiffness);
  EXPECT_NEAR(spring.excess() / (3.0 * impedance * kSpreading), 1.0, 1e-9) << "c Z u";
  EXPECT_NEAR(spring.walls.velocity[0], -kSpreading, 1e-9 * kSpreading);
}

TEST(Servo, that_follows_answers_a_step_with_critical_damping_and_leaves_no_error) {
  Spring spring(true);
  double at = 0.0;
  for (const double until : {1.0, 3.0, 6.0, 12.0, 30.0}) {
    spring.advance((until - at) * Spring::kLag, kSpreading);
    at = until;
    const double expected =
        2.0 * Spring::kStiffness * kSpreading * until * Spring::kLag * std::exp(-until / 3.0);
    // Steps of T / 1000 are off by about that over the 3 T of the answer.
    EXPECT_NEAR(spring.excess(), expected, 3e-3 * 2.0 * Spring::kStiffness * kSpreading * Spring::kLag);
    EXPECT_GE(spring.excess(), 0.0) << "no overshoot";
  }
  spring.advance(60.0 * Spring::kLag, kSpreading);
  EXPECT_NEAR(spring.walls.carried[0], -kSpreading, 1e-6 * kSpreading);
}

/// Of the next 100 T, with an answer that is late by T.
double largest_excess(Spring& spring) {
  double largest = 0.0;
  for (int k = 0; k < 100; ++k) {
    spring.advance(Spring::kLag, kSpreading, Spring::kLag);
    largest = std::max(largest, std::fabs(spring.excess()));
  }
  return largest;
}

TEST(Servo, that_follows_is_stable_over_the_gains_with_an_answer_as_late_as_the_specimen_gives_it) {
  for (const double impedances : {1.0, 3.0, 10.0}) {
    for (const double periods : {1.5, 3.0, 6.0, 12.0, 24.0}) {
      Spring spring(true, {impedances, periods});
      const double early = largest_excess(spring);
      for (int more = 0; more < 3; ++more) largest_excess(spring);
      EXPECT_LT(largest_excess(spring), 0.1 * early) << impedances << ", " << periods;
    }
  }
  // At the edge that the header gives: below it the error grows.
  Spring spring(true, {3.0, 0.8});
  const double early = largest_excess(spring);
  EXPECT_GT(largest_excess(spring), early);
}

TEST(Servo, carries_nothing_while_its_cap_holds_it) {
  Spring spring(true, {}, kSpreading);  // one wall may move at half of it
  spring.advance(30.0 * Spring::kLag, kSpreading);
  EXPECT_EQ(spring.walls.velocity[0], -0.5 * kSpreading);
  EXPECT_LT(std::fabs(spring.walls.carried[0]), 0.5 * kSpreading);
  const double carried = spring.walls.carried[0];
  spring.advance(30.0 * Spring::kLag, kSpreading);
  EXPECT_EQ(spring.walls.carried[0], carried);
  spring.control[0].follows = false;
  spring.advance(Spring::kLag, 0.0);
  EXPECT_EQ(spring.walls.carried[0], 0.0);
}

constexpr double kHeld = 3e6;  // [Pa]

/// Mean of lateral stress over target, less 1, over the samples between two axial strains.
double lag(const testing::Trace& trace, double from, double to) {
  double sum = 0.0, count = 0.0;
  for (const std::string& bytes : trace.records) {
    const Record record = *decode(bytes);
    if (record.kind != RecordKind::kSample) continue;
    const auto value = [&](const char* column) {
      return record.values[column_index(RecordKind::kSample, column)];
    };
    if (value("axial_strain") < from || value("axial_strain") > to) continue;
    sum += value("radial_stress_Pa") / kHeld - 1.0;
    count += 1.0;
  }
  return sum / count;
}

TEST(Servo, holds_the_sides_of_a_sheared_specimen_within_a_hundredth) {
  Experiment experiment;
  experiment.specimen.particles = 300;
  IsotropicStage isotropic;
  isotropic.until = {kHeld, Target::Measure::kMeanStress};
  isotropic.keep = Keep{};
  TriaxialStage shear;
  shear.until = {0.08, Target::Measure::kAxialStrain};
  shear.axial_velocity = 0.2;
  experiment.program = {isotropic, shear};
  const testing::Trace slow = testing::whole_run(experiment);
  ASSERT_EQ(slow.outcome, "completed");
  // From some strain past the isotropic state on. In proportion alone it is 2 to 8 % here, and grows: the cap
  // of the sides was that of the loading velocity.
  EXPECT_LT(std::fabs(lag(slow, 0.02, 0.08)), 0.01);

  // Near failure, at 0.5 m/s. Single breakages move the stress by some per cent, so it is a mean.
  shear.axial_velocity = 0.5;
  shear.until.value = 0.2;
  experiment.program = {shear};
  experiment.start = Start{"the same", slow.kept.front().name};
  auto run = Run::start_from(experiment, {}, slow.kept.front().bytes);
  ASSERT_TRUE(run.ok()) << run.status();
  testing::Trace fast;
  finish(**run, fast);
  ASSERT_EQ(fast.outcome, "completed");
  EXPECT_LT(std::fabs(lag(fast, 0.06, 0.2)), 0.01);
}

}  // namespace
}  // namespace creep
