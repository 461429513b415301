#include "core/physics/particle_count.h"

#include <gtest/gtest.h>

#include <limits>

namespace creep {
namespace {

Experiment oedometer(double axial_stress) {
  Experiment experiment;
  experiment.specimen.particles = 3000;
  experiment.program = {OedometricStage{{axial_stress, Target::Measure::kAxialStress}},
                        CreepStage{.duration = 172800.0, .axial_stress = {}}};
  return experiment;
}

TEST(ParticleCount, ACubeHoldsWhatFitsAtItsVoidRatio) {
  SpecimenSpec specimen;
  specimen.side = 4e-3;
  // The paper has 11 500 in such a cube; count, grading and void ratio are not all three exact there.
  EXPECT_NEAR(initial_particle_count(specimen), 11500.0, 2000.0);
  specimen.side.reset();
  EXPECT_EQ(initial_particle_count(specimen), 0.0);
  specimen.particles = 300;
  EXPECT_EQ(initial_particle_count(specimen), 300.0);
}

TEST(ParticleCount, CoversWhatRunsWereCrushedToAndNotThreeTimesThat) {
  const struct { double stress, counted; } runs[] = {{21.7e6, 5028.0}, {60e6, 14323.0}, {150e6, 29052.0}};
  for (const auto& run : runs) {
    const double guess = crushed_particle_count(oedometer(run.stress));
    EXPECT_GT(guess, 1.2 * run.counted) << run.stress;
    EXPECT_LT(guess, 3.0 * run.counted) << run.stress;
  }
}

TEST(ParticleCount, WeakerGrainsMakeMoreAndUnbreakableOnesNoFragments) {
  Experiment weak = oedometer(21.7e6);
  weak.material.limit_stress /= 2.0;
  EXPECT_GT(crushed_particle_count(weak), 1.3 * crushed_particle_count(oedometer(21.7e6)));
  weak.material.comminution_limit = std::numeric_limits<double>::infinity();
  EXPECT_EQ(crushed_particle_count(weak), 3000.0);
}

TEST(ParticleCount, AStressThatTheProgramLeavesOpenIsTakenHigh) {
  const double at_100_MPa = crushed_particle_count(oedometer(100e6));
  Experiment strained = oedometer(0.15);
  strained.program = {OedometricStage{{0.15, Target::Measure::kAxialStrain}}};
  EXPECT_EQ(crushed_particle_count(strained), at_100_MPa);
  strained.program = {IsotropicStage{{25e6, Target::Measure::kMeanStress}},
                      TriaxialStage{{0.1, Target::Measure::kAxialStrain}}};
  EXPECT_EQ(crushed_particle_count(strained), at_100_MPa);
  strained.program = {IsotropicStage{{25e6, Target::Measure::kMeanStress}},
                      TriaxialStage{{75e6, Target::Measure::kDeviatoricStress}}};
  EXPECT_EQ(crushed_particle_count(strained), at_100_MPa);
  Experiment inherited = oedometer(1e6);
  inherited.start = Start{"abcd", "1"};
  EXPECT_EQ(crushed_particle_count(inherited), crushed_particle_count(oedometer(30e6)));
}

}  // namespace
}  // namespace creep
