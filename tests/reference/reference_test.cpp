// The product against the plain engine: 1000 cycles of a crushing scene, bit for bit.
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <ostream>

#include "core/dem/particle_birth.h"
#include "core/dem/shear_history.h"
#include "core/dem/splitter.h"
#include "tests/core/dem_scenes.h"
#include "tests/reference/reference_engine.h"

namespace creep {
namespace {

using creep::testing::isotropic;
using creep::testing::packed;
using creep::testing::run_cycles;
using creep::testing::weak_sand;
using creep::testing::widest_kernels;

/// Equal bits, but for the sign of zero, which no sum can carry on.
bool same(double a, double b) {
  return std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b) || (a == 0.0 && b == 0.0);
}

void expect_equal_particles(const Specimen& specimen, const reference::Engine& engine) {
  const Particles& particles = specimen.particles;
  ASSERT_EQ(particles.size(), engine.grains().size());
  for (std::size_t i = 0; i < particles.size(); ++i) {
    const reference::Grain& grain = engine.grains()[i];
    ASSERT_EQ(particles.id[i], grain.id);
    ASSERT_EQ(particles.parent[i], grain.parent) << "grain " << grain.id;
    ASSERT_EQ(particles.generation[i], grain.generation) << "grain " << grain.id;
    for (Eigen::Index axis = 0; axis < 3; ++axis) {
      ASSERT_TRUE(same(particles.position(i)[axis], grain.position[axis])) << "grain " << grain.id;
      ASSERT_TRUE(same(particles.velocity(i)[axis], grain.velocity[axis])) << "grain " << grain.id;
      if (particles.spin.empty()) continue;
      const double spin[3] = {particles.spin[i].x, particles.spin[i].y, particles.spin[i].z};
      ASSERT_TRUE(same(spin[axis], grain.spin[axis])) << "grain " << grain.id;
    }
    ASSERT_TRUE(same(particles.body[i].radius, grain.radius)) << "grain " << grain.id;
    ASSERT_TRUE(same(particles.mass[i], grain.mass)) << "grain " << grain.id;
    ASSERT_TRUE(same(particles.limit_stress[i], grain.limit_stress)) << "grain " << grain.id;
    ASSERT_TRUE(same(particles.crack[i], grain.crack)) << "grain " << grain.id;
    ASSERT_TRUE(same(particles.mobilised_stress[i], grain.mobilised_stress)) << "grain " << grain.id;
  }
}

void expect_equal_shears(const Specimen& specimen, const reference::Engine& engine) {
  const std::vector<PairShear> history = shear_history(specimen.contacts);
  std::size_t loaded = 0;
  for (const auto& [pair, shear] : engine.shear()) {
    if (shear.isZero(0.0)) continue;
    ASSERT_LT(loaded, history.size());
    const PairShear& known = history[loaded++];
    ASSERT_EQ(specimen.particles.id[static_cast<std::size_t>(known.first)], pair.first);
    ASSERT_EQ(specimen.particles.id[static_cast<std::size_t>(known.second)], pair.second);
    ASSERT_TRUE(same(known.x, shear.x()) && same(known.y, shear.y()) && same(known.z, shear.z()))
        << "contact of " << pair.first << " and " << pair.second;
  }
  ASSERT_EQ(loaded, history.size());
}

void expect_equal_wall_shears(const Specimen& specimen, const reference::Engine& engine) {
  const Particles& particles = specimen.particles;
  std::size_t loaded = 0, rubbed = 0;
  for (const WallShear& shear : particles.wall_shear)
    for (const auto& wall : shear.across) loaded += wall[0] != 0.0 || wall[1] != 0.0 ? 1 : 0;
  for (const auto& [contact, shear] : engine.wall_shear()) {
    if (shear == std::array<double, 2>{}) continue;
    ++rubbed;
    const auto i = static_cast<std::size_t>(
        std::lower_bound(particles.id.begin(), particles.id.end(), contact.first) - particles.id.begin());
    ASSERT_LT(i, particles.wall_shear.size());
    const auto& known = particles.wall_shear[i].across[contact.second / 2];
    ASSERT_TRUE(same(known[0], shear[0]) && same(known[1], shear[1]))
        << "grain " << contact.first << " at wall " << contact.second;
  }
  ASSERT_EQ(loaded, rubbed);
}

void expect_equal_surroundings(const Specimen& specimen, const reference::Engine& engine) {
  for (std::size_t w = 0; w < 6; ++w) {
    ASSERT_TRUE(same(specimen.walls.position[w], engine.walls()[w].position)) << "wall " << w;
    ASSERT_TRUE(same(specimen.walls.velocity[w], engine.walls()[w].velocity)) << "wall " << w;
    ASSERT_TRUE(same(specimen.walls.force[w], engine.walls()[w].force)) << "wall " << w;
    ASSERT_TRUE(same(specimen.walls.stiffness[w], engine.walls()[w].stiffness)) << "wall " << w;
  }
  ASSERT_TRUE(same(specimen.time_step, engine.time_step()));
  ASSERT_TRUE(same(specimen.clocks.dynamic_time, engine.dynamic_time()));
  ASSERT_TRUE(same(specimen.unbalanced_force_ratio, engine.unbalanced_force_ratio()));
  ASSERT_TRUE(same(specimen.energy.wall_work, engine.wall_work()));
  ASSERT_EQ(specimen.broken_total, engine.broken());
  ASSERT_EQ(specimen.fines.size(), engine.fines().size());
  for (std::size_t k = 0; k < specimen.fines.size(); ++k) {
    ASSERT_TRUE(same(specimen.fines[k].mass, engine.fines()[k].mass));
    ASSERT_TRUE(same(specimen.fines[k].smallest_sibling, engine.fines()[k].smallest_sibling));
  }
}

struct Scene {
  const char* name;
  Material material;
  std::int64_t failure_check_interval = 1;
  WallControl control = isotropic(20e6, 2.0);

  friend void PrintTo(const Scene& scene, std::ostream* out) { *out << scene.name; }
};

std::vector<Scene> scenes() {
  const Material sand = weak_sand(150).material;
  std::vector<Scene> all;
  all.push_back({"rough", sand});
  all.push_back({"smooth", sand});
  all.back().material.roughness = 0.0;
  all.back().material.limit_stress = 4e9;  // smooth contacts are smaller, so stresses are higher
  all.push_back({"frictionless", sand});
  all.back().material.friction = 0.0;
  all.push_back({"turning", sand});
  all.back().material.free_rotation = true;
  all.push_back({"rubbed_by_walls", sand});
  all.back().material.wall_friction = 0.2;
  all.push_back({"turning_rubbed_by_walls", sand});
  all.back().material.free_rotation = true;
  all.back().material.wall_friction = 0.2;
  all.push_back({"tetrahedral_checked_every_7th", sand, 7});
  all.back().material.split_layout = SplitLayout::kTetrahedral;
  all.push_back({"cubic_with_fast_cracks", sand});
  all.back().material.split_layout = SplitLayout::kCubic;
  all.back().material.limit_stress = 6e9;  // none fails at once
  all.back().material.crack_velocity = 1e4;
  all.back().material.corrosion_index = 10.0;
  all.push_back({"triaxial", sand});
  all.back().control = isotropic(2e6, 2.0);
  all.back().control[2] = {AxisControl::Mode::kVelocity, 0.0, 4.0};
  all.back().control[0].follows = all.back().control[1].follows = true;
  all.push_back({"relaxation_with_held_sides", sand});
  all.back().material.limit_stress = 0.5e9;
  all.back().control = isotropic(4e6, 2.0);
  all.back().control[2] = {};
  all.back().control[0].follows = true;
  return all;
}

class ReferenceEngine : public ::testing::TestWithParam<Scene> {};

TEST_P(ReferenceEngine, crushes_like_the_product_bit_for_bit_for_1000_cycles) {
  Experiment experiment = weak_sand(150);
  experiment.material = GetParam().material;
  experiment.numerics.failure_check_interval = GetParam().failure_check_interval;
  Dynamics dynamics(experiment, widest_kernels(), {});
  Specimen specimen = packed(experiment, dynamics);
  let_walls_rub(specimen.particles, experiment.material);
  // Some grains start from rest, where local damping has no sign.
  for (std::size_t i = 0; i < specimen.particles.size(); i += 3) {
    Body& body = specimen.particles.body[i];
    body.vx = body.vy = body.vz = 0.0;
  }
  reference::Engine engine(experiment, specimen);
  dynamics.let_fail(true);
  const std::int64_t damping = specimen.energy.damping.low(), friction = specimen.energy.friction.low(),
                     tangential = specimen.energy.tangential_work.low();
  const WallControl& control = GetParam().control;
  for (int cycle = 0; cycle < 1000; ++cycle) {
    run_cycles(specimen, experiment, dynamics, control, 1);
    engine.cycle(control);
    // Every cycle the cheap way, so that a difference is caught where it arises.
    ASSERT_TRUE(same(specimen.walls.position[5], engine.walls()[5].position)) << "cycle " << cycle;
    ASSERT_EQ(specimen.particles.size(), engine.grains().size()) << "cycle " << cycle;
    if (cycle % 100 == 99) {
      SCOPED_TRACE(cycle);
      ASSERT_NO_FATAL_FAILURE(expect_equal_particles(specimen, engine));
      ASSERT_NO_FATAL_FAILURE(expect_equal_shears(specimen, engine));
      ASSERT_NO_FATAL_FAILURE(expect_equal_wall_shears(specimen, engine));
      ASSERT_NO_FATAL_FAILURE(expect_equal_surroundings(specimen, engine));
    }
  }
  EXPECT_EQ(specimen.energy.damping.low() - damping, engine.damping_quanta());
  EXPECT_EQ(specimen.energy.friction.low() - friction, engine.friction_quanta());
  EXPECT_EQ(specimen.energy.tangential_work.low() - tangential, engine.tangential_quanta());
  EXPECT_GE(specimen.broken_total, 5) << "the scene must crush to prove anything";
  double fastest = 0.0;
  for (const Spin& spin : specimen.particles.spin) fastest = std::max(fastest, std::fabs(spin.x));
  EXPECT_EQ(engine.wall_shear().empty(), experiment.material.wall_friction == 0.0) << "or rub";
  EXPECT_EQ(fastest > 0.0, experiment.material.free_rotation) << "or turn";
}

INSTANTIATE_TEST_SUITE_P(Scenes, ReferenceEngine, ::testing::ValuesIn(scenes()),
                         [](const auto& info) { return std::string(info.param.name); });

}  // namespace
}  // namespace creep
