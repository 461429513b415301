// The cycle: collisions, damping, clocks, the time step and the energy ledger.
#include "core/dem/dynamics.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/dem/measures.h"
#include "core/dem/particle_birth.h"
#include "core/dem/splitter.h"
#include "core/output/samples.h"
#include "core/state/state.h"
#include "tests/core/dem_scenes.h"

namespace creep {
namespace {

using testing::balls;
using testing::isotropic;
using testing::oedometric;
using testing::packed;
using testing::run_cycles;
using testing::unbreakable_sand;
using testing::weak_sand;
using testing::widest_kernels;

const WallControl kFixedWalls{};

Eigen::Vector3d momentum(const Specimen& specimen) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < specimen.particles.size(); ++i)
    sum += specimen.particles.mass[i] * specimen.particles.velocity(i);
  return sum;
}

TEST(Dynamics, an_oblique_collision_of_unequal_grains_conserves_momentum) {
  Experiment experiment;
  experiment.numerics.local_damping = 0.0;
  experiment.numerics.time_step_safety = 0.05;
  Dynamics dynamics(experiment, widest_kernels(), {});
  Specimen specimen =
      balls(experiment, 1e-2,
            {{5e-3, 5e-3, 5e-3, 0.1e-3, 2.0, 0.3, 0.1}, {5.16e-3, 5.05e-3, 5e-3, 0.06e-3, -3.0, 0.0, -0.4}});
  dynamics.assess(specimen);
  const Eigen::Vector3d before = momentum(specimen);
  bool touched = false;
  for (int cycle = 0; cycle < 5000; ++cycle) {
    dynamics.cycle(specimen, kFixedWalls);
    touched = touched || specimen.mean_overlap > 0.0;
  }
  ASSERT_TRUE(touched);
  EXPECT_GT(std::fabs(specimen.particles.velocity(0).y() - 0.3), 1e-3) << "friction did nothing";
  EXPECT_LT((momentum(specimen) - before).norm(), 1e-12 * before.norm());
}

TEST(Dynamics, free_flight_is_straight_and_undamped) {
  const Experiment experiment;
  Dynamics dynamics(experiment, widest_kernels(), {});
  Specimen specimen = balls(experiment, 1e-2, {{1e-3, 2e-3, 3e-3, 0.1e-3, 1.0, -0.5, 0.25}});
  dynamics.assess(specimen);
  run_cycles(specimen, experiment, dynamics, kFixedWalls, 1000);
  const double flown = specimen.clocks.dynamic_time;
  ASSERT_GT(flown, 0.0);
  EXPECT_EQ(specimen.particles.velocity(0), Eigen::Vector3d(1.0, -0.5, 0.25));
  const Eigen::Vector3d expected(1e-3 + flown, 2e-3 - 0.5 * flown, 3e-3 + 0.25 * flown);
  EXPECT_LT((specimen.particles.position(0) - expected).norm(), 1e-15);  // 1000 roundings of 1e-3
  EXPECT_EQ(specimen.energy.damping.value(), 0.0);
}

TEST(Dynamics, local_damping_brakes_with_and_against_the_force) {
  Experiment experiment;
  for (const double alpha : {0.0, 0.3, 0.7}) {
    experiment.numerics.local_damping = alpha;
    for (const double direction : {-1.0, 0.0, 1.0}) {
      Dynamics dynamics(experiment, widest_kernels(), {});
      // Pressed 0.5 um into the bottom wall, which pushes it upwards.
      constexpr double kRadius = 0.1e-3, kSpeed = 1e-6;
      Specimen specimen = balls(experiment, 1e-3, {{5e-4, 5e-4, kRadius - 0.5e-6, kRadius}});
      specimen.particles.body[0].vz = direction * kSpeed;
      dynamics.assess(specimen);
      const double force = specimen.walls.force[4];
      ASSERT_GT(force, 0.0);
      const double kick = 0.5 * specimen.time_step;
      dynamics.cycle(specimen, kFixedWalls);
      const double acceleration = (specimen.particles.body[0].vz - direction * kSpeed) / kick;
      const double undamped = force / specimen.particles.mass[0];
      // Moving with the force it gains less, against it it loses more. The wall force is counted in 2^-40 N.
      EXPECT_NEAR(acceleration / undamped, 1.0 - alpha * direction, 1e-9) << alpha << " " << direction;
    }
  }
}

/// Wall work and the part of it that no term of the ledger explains [J].
struct Ledger {
  double wall_work, unexplained, friction, damping, removed;
};

Ledger ledger(const Specimen& specimen, const Experiment& experiment, const Dynamics& dynamics) {
  RunState state;
  state.specimen = specimen;
  const std::vector<double> row = sample_values(state, experiment, dynamics.model(), Phase::kLoading);
  const auto value = [&](std::string_view name) { return row[column_index(RecordKind::kSample, name)]; };
  return {value("wall_work_J"), value("energy_unexplained_J"), value("friction_J"), value("damping_J"),
          value("removed_J")};
}

/// What takes part in it beside normal contact and sliding of grains that do not turn.
struct LedgerScene {
  const char* name;
  bool free_rotation;
  double wall_friction;
};

class EnergyLedger : public ::testing::TestWithParam<LedgerScene> {
 protected:
  static void choose(Experiment& experiment) {
    experiment.material.free_rotation = GetParam().free_rotation;
    experiment.material.wall_friction = GetParam().wall_friction;
  }
};

TEST_P(EnergyLedger, explains_a_compression_to_one_thousandth) {
  Experiment experiment = unbreakable_sand(200);
  choose(experiment);
  Dynamics dynamics(experiment, widest_kernels(), {});
  Specimen specimen = packed(experiment, dynamics);
  let_walls_rub(specimen.particles, experiment.material);
  dynamics.let_fail(true);
  ASSERT_EQ(run_cycles(specimen, experiment, dynamics, oedometric(10e6, 0.5), 20000), 0);
  const Ledger energy = ledger(specimen, experiment, dynamics);
  EXPECT_GT(specimen.walls.stress(2), 5e6);
  EXPECT_GT(energy.friction, 0.01 * energy.wall_work);
  EXPECT_GT(energy.damping, 1e-3 * energy.wall_work);
  EXPECT_LE(std::fabs(energy.unexplained), 1e-3 * energy.wall_work);
}

TEST_P(EnergyLedger, explains_a_crushing_compression_to_one_thousandth) {
  Experiment experiment = weak_sand(200);
  choose(experiment);
  Dynamics dynamics(experiment, widest_kernels(), {});
  Specimen specimen = packed(experiment, dynamics);
  let_walls_rub(specimen.particles, experiment.material);
  dynamics.let_fail(true);
  EXPECT_GT(run_cycles(specimen, experiment, dynamics, oedometric(3e6, 0.5), 10000), 5);
  const Ledger energy = ledger(specimen, experiment, dynamics);
  EXPECT_GT(energy.removed, 0.0);
  EXPECT_LE(std::fabs(energy.unexplained), 1e-3 * energy.wall_work);
}

INSTANTIATE_TEST_SUITE_P(Scenes, EnergyLedger,
                         ::testing::Values(LedgerScene{"blocked", false, 0.0}, LedgerScene{"free", true, 0.0},
                                           LedgerScene{"rubbed", false, 0.3},
                                           LedgerScene{"free_rubbed", true, 0.3}),
                         [](const auto& info) { return std::string(info.param.name); });

TEST(Dynamics, no_shear_force_exceeds_coulombs_cap_and_some_reach_it) {
  const Experiment experiment = unbreakable_sand(150);
  Dynamics dynamics(experiment, widest_kernels(), {});
  Specimen specimen = packed(experiment, dynamics);
  run_cycles(specimen, experiment, dynamics, oedometric(5e6, 1.0), 2000);
  dynamics.assess(specimen);
  const Contacts& contacts = specimen.contacts;
  int sliding = 0, touching = 0;
  for (std::size_t c = 0; c < contacts.count; ++c) {
    const Body& a = specimen.particles.body[static_cast<std::size_t>(contacts.first[c])];
    const Body& b = specimen.particles.body[static_cast<std::size_t>(contacts.second[c])];
    const double cap =
        experiment.material.friction * dynamics.model().between(a, b, contacts.root_radius[c]).force;
    const double shear = std::hypot(contacts.shear_x[c], contacts.shear_y[c], contacts.shear_z[c]);
    EXPECT_LE(shear, cap * (1.0 + 1e-12));  // rounding of the scaling
    touching += cap > 0.0;
    sliding += cap > 0.0 && shear > 0.999 * cap;
  }
  EXPECT_GT(touching, 150);
  EXPECT_GT(sliding, 0);
  EXPECT_LT(sliding, touching);
}

/// sqrt2 min sqrt(m/K), K the sum of normal stiffnesses of a grain's contacts as they stand [s].
double largest_stable_step(const Specimen& specimen, const ContactModel& model) {
  const Particles& particles = specimen.particles;
  std::vector<double> stiffness(particles.size(), 0.0);
  for (std::size_t i = 0; i < particles.size(); ++i) {
    for (std::size_t j = i + 1; j < particles.size(); ++j) {
      const double r1 = particles.body[i].radius, r2 = particles.body[j].radius;
      const double k =
          model.between(particles.body[i], particles.body[j], std::sqrt(r1 * r2 / (r1 + r2))).stiffness;
      stiffness[i] += k;
      stiffness[j] += k;
    }
    for (std::size_t w = 0; w < 6; ++w) {
      const double along = particles.position(i)[static_cast<Eigen::Index>(w / 2)];
      const double gap = w % 2 == 0 ? along - specimen.walls.position[w] : specimen.walls.position[w] - along;
      stiffness[i] += model.at_wall(particles.body[i], gap).stiffness;
    }
  }
  double step = 1e9;
  for (std::size_t i = 0; i < particles.size(); ++i) {
    if (stiffness[i] > 0.0) step = std::min(step, std::sqrt(2.0 * particles.inertial_mass[i] / stiffness[i]));
  }
  return step;
}

/// The floor throws up a grain that slides over it: Coulomb's law holds for the impulses.
TEST(WallFriction, takes_mu_times_the_normal_impulse_from_a_grain_that_slides) {
  Experiment experiment;
  experiment.material.wall_friction = 0.4;
  experiment.numerics.local_damping = 0.0;
  experiment.numerics.time_step_safety = 0.1;
  Dynamics dynamics(experiment, widest_kernels(), {});
  const double radius = 0.1e-3, overlap = 0.5e-6;
  Specimen specimen = balls(experiment, 5e-3, {{2e-3, 3e-3, radius - overlap, radius, 150.0, -200.0, 0.0}});
  let_walls_rub(specimen.particles, experiment.material);
  dynamics.assess(specimen);
  const Body& grain = specimen.particles.body[0];
  dynamics.cycle(specimen, kFixedWalls);  // it has not moved yet, so nothing rubs
  const Body first = grain;
  for (int cycle = 0; cycle < 20000 && grain.z < radius; ++cycle) dynamics.cycle(specimen, kFixedWalls);
  dynamics.cycle(specimen, kFixedWalls);
  ASSERT_GT(grain.vz, 10.0 * first.vz);
  EXPECT_NEAR(std::hypot(first.vx - grain.vx, grain.vy - first.vy), 0.4 * (grain.vz - first.vz),
              1e-9 * grain.vz);
  EXPECT_NEAR(grain.vy / grain.vx, -2.0 / 1.5, 1e-12) << "against its way";
  EXPECT_EQ(specimen.particles.wall_shear[0].across[2][0], 0.0) << "a contact that opens forgets";
}

/// Where the sides carry a part of the load, less of it reaches the middle. The least that can is what
/// Janssen (1895) found for friction mobilised all over: d(sigma)/dz = -4 mu K sigma / L, K the measured
/// ratio of side to platen stress.
TEST(WallFriction, keeps_a_part_of_the_platens_load_from_the_middle_of_an_oedometer) {
  for (const double wall_friction : {0.0, 0.3}) {
    Experiment experiment = unbreakable_sand(400);
    experiment.material.wall_friction = wall_friction;
    Dynamics dynamics(experiment, widest_kernels(), {});
    Specimen specimen = packed(experiment, dynamics);
    let_walls_rub(specimen.particles, experiment.material);
    run_cycles(specimen, experiment, dynamics, oedometric(10e6, 0.5), 30000);
    const Walls& walls = specimen.walls;
    ASSERT_NEAR(walls.stress(2), 10e6, 0.1e6);
    double upward = walls.force[4] - walls.force[5];
    for (const WallShear& shear : specimen.particles.wall_shear)
      upward += shear.across[0][1] + shear.across[1][0];
    EXPECT_LT(std::fabs(upward), 0.01 * walls.force[5]) << "the walls' forces hold each other";
    dynamics.ensure_list(specimen);
    const double share = contact_stress(specimen, dynamics.model()).axial / walls.stress(2);
    if (wall_friction == 0.0) {
      EXPECT_NEAR(share, 1.0, 0.01);
      continue;
    }
    const double ratio = 0.5 * (walls.stress(0) + walls.stress(1)) / walls.stress(2);
    const double mobilised = 2.0 * wall_friction * ratio;
    EXPECT_LT(share, 0.96);
    EXPECT_GT(share, (1.0 - std::exp(-mobilised)) / mobilised - 0.01);
  }
}

TEST(TimeStep, is_the_safety_times_the_stable_step_right_after_an_assessment) {
  const Experiment experiment = unbreakable_sand(150);
  Dynamics dynamics(experiment, widest_kernels(), {});
  Specimen specimen = packed(experiment, dynamics);
  run_cycles(specimen, experiment, dynamics, isotropic(5e6, 1.0), 1000);
  dynamics.assess(specimen);
  // A grain without contact may ask for less, never for more.
  const double stable = largest_stable_step(specimen, dynamics.model());
  EXPECT_LE(specimen.time_step, experiment.numerics.time_step_safety * stable * (1.0 + 1e-12));
  EXPECT_GE(specimen.time_step, 0.5 * experiment.numerics.time_step_safety * stable);
}

TEST(TimeStep, drops_at_once_with_the_first_split_and_stays_stable_while_grains_crush) {
  const Experiment experiment = weak_sand(100);
  Dynamics dynamics(experiment, widest_kernels(), {});
  Specimen specimen = packed(experiment, dynamics);
  dynamics.let_fail(true);
  const WallControl control = isotropic(5e6, 1.0);
  const double unbroken = specimen.time_step;
  double smallest = unbroken;
  bool first = true;
  for (int cycle = 0; cycle < 2000; ++cycle) {
    const CycleResult result = dynamics.cycle(specimen, control);
    const double before = specimen.time_step;
    split(specimen, experiment, dynamics, result.failures);
    if (!result.failures.empty() && first) {
      EXPECT_LT(specimen.time_step, before);
      first = false;
    }
    smallest = std::min(smallest, specimen.time_step);
    if (cycle % 20 == 0) {
      ASSERT_LT(specimen.time_step, largest_stable_step(specimen, dynamics.model())) << "cycle " << cycle;
    }
  }
  EXPECT_FALSE(first) << "nothing broke";
  EXPECT_LT(smallest, 0.25 * unbroken);  // fragments five times smaller
}

TEST(Clocks, scaled_inertia_stops_cracks_and_dynamic_time_but_not_immediate_failure) {
  Experiment experiment = weak_sand(100);
  experiment.numerics.inertia_scaling = InertiaScaling::kAll;
  experiment.material.crack_velocity = 1e3;  // anything that grew would show
  Dynamics dynamics(experiment, widest_kernels(), {});
  Specimen specimen = packed(experiment, dynamics);
  const std::vector<double> cracks = specimen.particles.crack;
  const std::vector<std::uint64_t> ids = specimen.particles.id;
  dynamics.let_fail(true);
  EXPECT_GT(run_cycles(specimen, experiment, dynamics, isotropic(5e6, 1.0), 2000), 0);
  EXPECT_EQ(specimen.clocks.dynamic_time, 0.0);
  EXPECT_GT(specimen.clocks.suspended_time, 0.0);
  EXPECT_EQ(specimen.clocks.age, 0.0);
  for (std::size_t i = 0; i < specimen.particles.size() && specimen.particles.id[i] < ids.size(); ++i) {
    EXPECT_EQ(specimen.particles.crack[i], cracks[specimen.particles.id[i]]);
  }
}

TEST(Clocks, physical_inertia_grows_cracks_with_dynamic_time) {
  Experiment experiment = weak_sand(100);
  experiment.material.crack_velocity = 1e2;
  experiment.material.corrosion_index = 5.0;
  experiment.material.limit_stress = 1e10;  // none fails at once
  Dynamics dynamics(experiment, widest_kernels(), {});
  Specimen specimen = packed(experiment, dynamics);
  const double crack = specimen.particles.crack[0];
  dynamics.let_fail(true);
  std::int64_t by_cracks = 0;
  for (int cycle = 0; cycle < 3000; ++cycle) {
    const CycleResult result = dynamics.cycle(specimen, isotropic(5e6, 1.0));
    for (const Failure& failure : result.failures) {
      EXPECT_EQ(failure.cause, FailureCause::kCrackInDynamicStage);
      const auto i = static_cast<std::size_t>(failure.index);
      EXPECT_GE(specimen.particles.crack[i], specimen.particles.body[i].radius);
      ++by_cracks;
    }
    split(specimen, experiment, dynamics, result.failures);
  }
  EXPECT_GT(by_cracks, 0);
  EXPECT_GT(specimen.clocks.dynamic_time, 0.0);
  EXPECT_EQ(specimen.clocks.suspended_time, 0.0);
  if (specimen.particles.id[0] == 0) {
    EXPECT_GT(specimen.particles.crack[0], crack);
  }
}

}  // namespace
}  // namespace creep
