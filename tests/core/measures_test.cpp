// What is read off a specimen, against cases worked by hand.
#include "core/dem/measures.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/core/dem_scenes.h"

namespace creep {
namespace {

using testing::balls;
using testing::widest_kernels;

/// Grains of one radius in a row, not touching.
Specimen row(double radius, std::size_t count) {
  std::vector<testing::Ball> given;
  for (std::size_t i = 0; i < count; ++i)
    given.push_back({3.0 * radius * (1.0 + static_cast<double>(i)), 0, 0, radius});
  return balls(Experiment{}, 1.0, given);
}

TEST(VoidRatio, counts_fines_as_solid_or_not) {
  const Material material;
  Specimen specimen = row(0.1e-3, 10);
  const double side = 1e-3;
  for (std::size_t axis = 0; axis < 3; ++axis) specimen.walls.position[2 * axis + 1] = side;
  const double grain = 4.0 / 3.0 * std::numbers::pi * 1e-12;
  const double mass = grain * material.density;
  EXPECT_NEAR(particle_mass(specimen) / (10 * mass), 1.0, 1e-14);
  specimen.fines = {{2.0 * mass, 0.02e-3}, {0.5 * mass, 0.03e-3}};
  EXPECT_NEAR(fines_mass(specimen) / (2.5 * mass), 1.0, 1e-14);
  const VoidRatio e = void_ratio(specimen, material.density);
  EXPECT_NEAR(e.of_particles, 1e-9 / (10.0 * grain) - 1.0, 1e-12);
  EXPECT_NEAR(e.with_fines, 1e-9 / (12.5 * grain) - 1.0, 1e-12);
}

/// Area under the fractal limit on a ln d axis, up to `top`, by its integral.
double fractal_area(double top) {
  const Material m;
  const double a = 3.0 - m.fractal_dimension, low = m.grading_index_min_diameter;
  const double high = m.grading_index_max_diameter;
  const double span = std::pow(top, a) - std::pow(low, a);
  const double below = span / a - std::pow(low, a) * std::log(top / low);
  return below / span + std::log(high / top);
}

TEST(GradingIndexOfSpecimen, is_that_of_the_worked_cases) {
  const Material material;
  const double high = material.grading_index_max_diameter, low = material.grading_index_min_diameter;
  const double whole = fractal_area(high);
  EXPECT_NEAR(grading_index(row(0.5 * high, 5), material), 0.0, 1e-12);
  EXPECT_NEAR(grading_index(row(0.5 * 0.4e-3, 5), material), 0.0, 1e-15) << "coarser adds no area";
  EXPECT_NEAR(grading_index(row(0.5 * low, 5), material), std::log(high / low) / whole, 1e-12);
  EXPECT_NEAR(grading_index(row(0.5 * 0.1e-3, 5), material), std::log(high / 0.1e-3) / whole, 1e-12);
  // Half the mass at 0.1 mm, a quarter coarser than the limit, a quarter fines below 0.05 mm.
  Specimen mixed = balls(Experiment{}, 1.0, {{0.1, 0, 0, 0.05e-3}, {0.2, 0, 0, 0.2e-3}});
  mixed.particles.mass = {2.0, 1.0};
  mixed.fines = {{1.0, 0.05e-3}};
  EXPECT_NEAR(grading_index(mixed, material),
              (0.5 * std::log(high / 0.1e-3) + 0.25 * fractal_area(0.05e-3)) / whole, 1e-12);
  Specimen limit = row(0.5 * 0.1e-3, 1);
  limit.particles.mass = {0.0};
  limit.fines = {{1.0, high}};
  EXPECT_NEAR(grading_index(limit, material), 1.0, 1e-12) << "all of it fractal";
}

TEST(Passing, steps_at_grains_and_runs_fractal_below_fragments) {
  Specimen specimen = balls(Experiment{}, 1.0, {{0.1, 0, 0, 0.05e-3}, {0.2, 0, 0, 0.1e-3}});
  specimen.particles.mass = {1.0, 2.0};
  specimen.fines = {{1.0, 0.05e-3}};
  const double at = 0.02e-3, a = 0.4;
  const std::vector<double> finer =
      passing(specimen, Material{}, {0.005e-3, at, 0.06e-3, 0.1e-3, 0.15e-3, 0.2e-3});
  EXPECT_DOUBLE_EQ(finer[0], 0.0);
  EXPECT_NEAR(finer[1],
              0.25 * (std::pow(at, a) - std::pow(1e-5, a)) / (std::pow(5e-5, a) - std::pow(1e-5, a)), 1e-12);
  EXPECT_DOUBLE_EQ(finer[2], 0.25);
  EXPECT_DOUBLE_EQ(finer[3], 0.5);
  EXPECT_DOUBLE_EQ(finer[4], 0.5);
  EXPECT_DOUBLE_EQ(finer[5], 1.0);
}

/// Three grains in a column that presses on bottom and top, and one that floats.
struct Column {
  Column() : dynamics(experiment, widest_kernels(), {}) {
    constexpr double kRadius = 0.1e-3, kOverlap = 0.2e-6, kStep = 2.0 * kRadius - kOverlap;
    const double bottom = kRadius - kOverlap;
    specimen = balls(experiment, 2.0 * bottom + 2.0 * kStep,
                     {{3e-4, 3e-4, bottom, kRadius},
                      {3e-4, 3e-4, bottom + kStep, kRadius},
                      {3e-4, 3e-4, bottom + 2.0 * kStep, kRadius},
                      {4.9e-4, 4.9e-4, 1.5e-4, 0.05e-3}});
    dynamics.assess(specimen);
  }
  Experiment experiment;
  Dynamics dynamics;
  Specimen specimen;
};

TEST(Coordination, counts_walls_once_and_sets_rattlers_aside) {
  Column column;
  const Coordination z = coordination(column.specimen, column.dynamics.model());
  EXPECT_DOUBLE_EQ(z.all, 6.0 / 4.0);
  EXPECT_DOUBLE_EQ(z.without_rattlers, 2.0);
}

TEST(ContactStress, of_a_column_is_its_force_over_the_area) {
  Column column;
  const ContactModel& model = column.dynamics.model();
  const Walls& walls = column.specimen.walls;
  const auto& body = column.specimen.particles.body;
  const double wall = model.at_wall(body[0], body[0].z).force;
  EXPECT_NEAR(walls.force[4] / wall, 1.0, 1e-9);  // counted in 2^-40 N
  const ContactStress stress = contact_stress(column.specimen, model);
  const double pair = model.between(body[0], body[1], std::sqrt(0.05e-3)).force;
  const double sum = 2.0 * wall * body[0].z + 2.0 * pair * (body[1].z - body[0].z);
  EXPECT_NEAR(stress.axial / (sum / walls.volume()), 1.0, 1e-12);
  EXPECT_EQ(stress.radial, 0.0);
}

TEST(ElasticEnergy, of_a_column_is_the_work_of_closing_its_contacts) {
  Column column;
  const ContactModel& model = column.dynamics.model();
  const double overlap = 0.2e-6;
  // Two walls with r' = R, two pairs with r' = R/2.
  const double expected =
      (2.0 * model.wall_modulus * std::sqrt(0.1e-3) + 2.0 * model.modulus * std::sqrt(0.05e-3)) *
      model.law.energy(overlap);
  const ElasticEnergy energy = elastic_energy(column.specimen, model);
  EXPECT_NEAR(energy.normal / expected, 1.0, 1e-9);  // overlaps of 2e-7 m from positions of 1e-3 m
  EXPECT_EQ(energy.tangential, 0.0);
}

TEST(ContactStress, agrees_with_the_walls_on_a_settled_packing) {
  const Experiment experiment = testing::unbreakable_sand(200);
  Dynamics dynamics(experiment, widest_kernels(), {});
  const Specimen specimen = testing::packed(experiment, dynamics);
  const ContactStress stress = contact_stress(specimen, dynamics.model());
  // In equilibrium they are the same integral; packing ends at an unbalanced force ratio of 1e-3.
  EXPECT_NEAR(stress.axial / specimen.walls.stress(2), 1.0, 0.01);
  EXPECT_NEAR(stress.radial / (0.5 * (specimen.walls.stress(0) + specimen.walls.stress(1))), 1.0, 0.01);
}

TEST(Strains, are_engineering_and_compression_positive) {
  Specimen specimen = row(0.1e-3, 1);
  EXPECT_EQ(axial_strain(specimen), 0.0) << "before the end of packing";
  specimen.initial_height = 1.0;
  specimen.initial_volume = 1.0;
  specimen.walls.position = {0.0, 0.9, 0.0, 1.0, 0.0, 0.8};
  EXPECT_NEAR(axial_strain(specimen), 0.2, 1e-15);
  EXPECT_NEAR(volumetric_strain(specimen), 0.28, 1e-15);
}

}  // namespace
}  // namespace creep
