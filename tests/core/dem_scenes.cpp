#include "tests/core/dem_scenes.h"

#include <gtest/gtest.h>

#include "core/dem/particle_birth.h"
#include "core/dem/splitter.h"

namespace creep::testing {

Experiment weak_sand(std::int64_t particles) {
  Experiment experiment;
  experiment.specimen.particles = particles;
  experiment.specimen.void_ratio = 1.0;
  experiment.material.limit_stress = 1.5e9;
  experiment.material.comminution_limit = 0.06e-3;
  return experiment;
}

Experiment unbreakable_sand(std::int64_t particles) {
  Experiment experiment = weak_sand(particles);
  experiment.material.comminution_limit = 1.0;
  return experiment;
}

const Kernels& widest_kernels() {
  if (avx512_kernels() != nullptr) return *avx512_kernels();
  if (avx2_kernels() != nullptr) return *avx2_kernels();
  return portable_kernels();
}

Specimen packed(const Experiment& experiment, Dynamics& dynamics, PackingState* state) {
  PackingState own;
  PackingState& packing = state != nullptr ? *state : own;
  Specimen specimen = scatter(experiment);
  while (packing.step != PackingState::Step::kDone) {
    const PackingFault fault = pack_one_cycle(specimen, packing, experiment, dynamics);
    EXPECT_EQ(fault, "");
    if (!fault.empty()) break;
  }
  return specimen;
}

Specimen balls(const Experiment& experiment, double side, const std::vector<Ball>& given) {
  Specimen specimen;
  for (std::size_t axis = 0; axis < 3; ++axis) specimen.walls.position[2 * axis + 1] = side;
  for (const Ball& ball : given) {
    Birth birth;
    birth.id = birth.parent = specimen.next_id++;
    birth.radius = ball.radius;
    const double position[3] = {ball.x, ball.y, ball.z}, velocity[3] = {ball.vx, ball.vy, ball.vz};
    for (int axis = 0; axis < 3; ++axis) {
      birth.position[axis] = position[axis];
      birth.velocity[axis] = velocity[axis];
    }
    append_particle(specimen.particles, experiment, birth);
    specimen.initial_mass += specimen.particles.mass.back();
  }
  specimen.friction = experiment.material.friction;
  return specimen;
}

WallControl isotropic(double stress, double closing_velocity) {
  WallControl control{};
  for (AxisControl& axis : control) axis = {AxisControl::Mode::kServo, stress, closing_velocity};
  return control;
}

WallControl oedometric(double stress, double closing_velocity) {
  WallControl control{};
  control[2] = {AxisControl::Mode::kServo, stress, closing_velocity};
  return control;
}

std::int64_t run_cycles(Specimen& specimen, const Experiment& experiment, Dynamics& dynamics,
                        const WallControl& control, std::int64_t cycles) {
  const std::int64_t before = specimen.broken_total;
  for (std::int64_t k = 0; k < cycles; ++k) {
    const CycleResult result = dynamics.cycle(specimen, control);
    split(specimen, experiment, dynamics, result.failures);
  }
  return specimen.broken_total - before;
}

}  // namespace creep::testing
