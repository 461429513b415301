// What the incremental tangential law does in a closed path of two grains: sheared while they are pressed
// together, let apart a little, sheared back, pressed together again. Its stiffness follows the overlap, so
// the way back is softer than the way out and gives back more than was put in: energy from nothing, as Elata
// and Berryman (1996), Mechanics of Materials 24:229-240, show for such laws. The amount is known, so it can
// be told from an error of ours.
#include <gtest/gtest.h>

#include <cmath>

#include "core/dem/dynamics.h"
#include "tests/core/dem_scenes.h"
#include "tests/validation/known_answers.h"

namespace creep {
namespace {

using testing::balls;
using testing::widest_kernels;
using validation::KnownAnswers;

constexpr double kRadius = 0.1;      // [m]
constexpr double kPressed = 2e-6;    // overlap [m]
constexpr double kApart = 0.5e-6;    // overlap [m]
constexpr double kShear = 1e-9;      // [m]; far from sliding
constexpr double kStep = 1e-8;       // [s]
constexpr double kImmovable = 1e15;  // [kg]: the path is given, not computed
constexpr int kCycles = 1000;        // a leg

/// Moves the second grain over the first by (x, y) in even steps.
void move(Dynamics& dynamics, Specimen& specimen, double x, double y) {
  Body& second = specimen.particles.body[1];
  for (int cycle = 0; cycle < kCycles; ++cycle) {
    second.vx = x / (kCycles * kStep);
    second.vy = y / (kCycles * kStep);
    specimen.time_step = kStep;
    dynamics.cycle(specimen, WallControl{});
  }
  // The last drift has its force in the next cycle.
  second.vx = second.vy = 0.0;
  specimen.last_time_step = kStep;
}

/// Tangential stiffness of the pair at an overlap [N/m].
double tangential_stiffness(const ContactModel& model, const Specimen& specimen, double overlap) {
  Body second = specimen.particles.body[0];
  second.x += 2.0 * kRadius - overlap;
  return model.tangential_ratio *
         model.between(specimen.particles.body[0], second, std::sqrt(0.5 * kRadius)).stiffness;
}

TEST(ShearCycle, makes_the_energy_of_the_incremental_law_and_no_other) {
  KnownAnswers answers("energy made in a closed path of shear and overlap", 2e-5,
                       "the sheared grains move apart across a turned normal: 1.5e-6 m over 0.2 m, twice");
  for (const double roughness : {0.0, 0.6e-6}) {
    Experiment experiment;
    experiment.material.roughness = roughness;
    experiment.numerics.local_damping = 0.0;
    Specimen specimen = balls(experiment, 20.0 * kRadius,
                              {{8.0 * kRadius, 8.0 * kRadius, 8.0 * kRadius, kRadius, 0, 0, 0},
                               {10.0 * kRadius - kPressed, 8.0 * kRadius, 8.0 * kRadius, kRadius, 0, 0, 0}});
    for (double& mass : specimen.particles.inertial_mass) mass = kImmovable;
    Dynamics dynamics(experiment, widest_kernels(), {});
    dynamics.assess(specimen);
    move(dynamics, specimen, 0.0, kShear);
    move(dynamics, specimen, kPressed - kApart, 0.0);
    move(dynamics, specimen, 0.0, -kShear);
    move(dynamics, specimen, kApart - kPressed, 0.0);
    move(dynamics, specimen, 0.0, 0.0);
    const double lost_stiffness = tangential_stiffness(dynamics.model(), specimen, kPressed) -
                                  tangential_stiffness(dynamics.model(), specimen, kApart);
    EXPECT_EQ(specimen.energy.friction.value(), 0.0) << "the grains slid";
    answers.relative(-specimen.energy.tangential_work.value(), 0.5 * lost_stiffness * kShear * kShear,
                     roughness == 0.0 ? "smooth" : "rough");
  }
}

}  // namespace
}  // namespace creep
