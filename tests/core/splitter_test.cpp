// What a broken grain leaves behind.
#include "core/dem/splitter.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <string>

#include "core/dem/measures.h"
#include "core/dem/shear_history.h"
#include "core/physics/split_geometry.h"
#include "tests/core/dem_scenes.h"

namespace creep {
namespace {

using testing::isotropic;
using testing::packed;
using testing::weak_sand;
using testing::widest_kernels;

/// A packed specimen loaded until a cycle reports failures that nobody has split yet.
struct AboutToBreak {
  explicit AboutToBreak(Experiment asked)
      : experiment(std::move(asked)), dynamics(experiment, widest_kernels(), {}) {
    specimen = packed(experiment, dynamics);
    dynamics.let_fail(true);
    for (int cycle = 0; cycle < 20000 && failures.empty(); ++cycle) {
      failures = dynamics.cycle(specimen, isotropic(5e6, 1.0)).failures;
    }
    EXPECT_FALSE(failures.empty());
  }
  Experiment experiment;
  Dynamics dynamics;
  Specimen specimen;
  std::vector<Failure> failures;
};

/// Place in the layout of a sibling that lies on local +z.
std::size_t sibling_on_z(SplitLayout layout) {
  switch (layout) {
    case SplitLayout::kOctahedral:
      return 4;
    case SplitLayout::kCubic:
      return 12;
    case SplitLayout::kTetrahedral:
      return 0;
  }
  return 0;
}

/// Direction of the largest normal force on grain i, by brute force.
Eigen::Vector3d most_loaded(const Specimen& specimen, const ContactModel& model, std::size_t i) {
  const Body& body = specimen.particles.body[i];
  double largest = 0.0;
  Eigen::Vector3d direction = Eigen::Vector3d::UnitZ();
  for (std::size_t j = 0; j < specimen.particles.size(); ++j) {
    if (j == i) continue;
    const Body& other = specimen.particles.body[j];
    const double reduced = body.radius * other.radius / (body.radius + other.radius);
    const double force = model.between(body, other, std::sqrt(reduced)).force;
    if (force <= largest) continue;
    largest = force;
    direction = (specimen.particles.position(j) - specimen.particles.position(i)).normalized();
  }
  for (std::size_t w = 0; w < 6; ++w) {
    const auto axis = static_cast<Eigen::Index>(w / 2);
    const double along = specimen.particles.position(i)[axis];
    const double outward = w % 2 == 0 ? -1.0 : 1.0;
    const double force = model.at_wall(body, outward * (specimen.walls.position[w] - along)).force;
    if (force <= largest) continue;
    largest = force;
    direction = outward * Eigen::Vector3d::Unit(axis);
  }
  return direction;
}

class Split : public ::testing::TestWithParam<SplitLayout> {
 protected:
  Split() : scene_(asked()) {}
  static Experiment asked() {
    Experiment experiment = weak_sand(80);
    experiment.material.split_layout = GetParam();
    return experiment;
  }
  AboutToBreak scene_;
};

TEST_P(Split, replaces_a_grain_by_14_inside_it_with_its_velocity_and_new_ids) {
  Specimen& specimen = scene_.specimen;
  const Specimen before = specimen;
  split(specimen, scene_.experiment, scene_.dynamics, scene_.failures);
  const Particles& particles = specimen.particles;
  const std::size_t broken = scene_.failures.size();
  const std::size_t survivors = before.particles.size() - broken;
  ASSERT_EQ(particles.size(), survivors + kSiblingCount * broken);
  EXPECT_EQ(specimen.broken_total, before.broken_total + static_cast<std::int64_t>(broken));
  EXPECT_TRUE(std::is_sorted(particles.id.begin(), particles.id.end()));
  EXPECT_EQ(std::set(particles.id.begin(), particles.id.end()).size(), particles.size());
  EXPECT_EQ(specimen.next_id, before.next_id + kSiblingCount * broken);
  for (std::size_t k = 0; k < broken; ++k) {
    const auto p = static_cast<std::size_t>(scene_.failures[k].index);
    const double radius = before.particles.body[p].radius;
    EXPECT_FALSE(std::binary_search(particles.id.begin(), particles.id.end(), before.particles.id[p]));
    for (std::size_t s = 0; s < kSiblingCount; ++s) {
      const std::size_t i = survivors + k * kSiblingCount + s;
      EXPECT_EQ(particles.id[i], before.next_id + k * kSiblingCount + s);
      EXPECT_EQ(particles.parent[i], before.particles.id[p]);
      EXPECT_EQ(particles.generation[i], before.particles.generation[p] + 1);
      EXPECT_EQ(particles.velocity(i), before.particles.velocity(p));
      const double away = (particles.position(i) - before.particles.position(p)).norm();
      // Tangent to the parent from inside, to the rounding of positions of 1e-3 m.
      EXPECT_NEAR(away + particles.body[i].radius, radius, 1e-17);
      EXPECT_GE(particles.crack[i], 0.001 * 2.0 * particles.body[i].radius);
      EXPECT_LE(particles.crack[i], particles.body[i].radius);
    }
  }
}

TEST_P(Split, puts_local_z_along_the_largest_contact_force) {
  Specimen& specimen = scene_.specimen;
  std::vector<Eigen::Vector3d> centre, expected;
  for (const Failure& failure : scene_.failures) {
    const auto i = static_cast<std::size_t>(failure.index);
    centre.push_back(specimen.particles.position(i));
    expected.push_back(most_loaded(specimen, scene_.dynamics.model(), i));
  }
  const std::size_t survivors = specimen.particles.size() - scene_.failures.size();
  split(specimen, scene_.experiment, scene_.dynamics, scene_.failures);
  for (std::size_t k = 0; k < centre.size(); ++k) {
    const std::size_t i = survivors + k * kSiblingCount + sibling_on_z(GetParam());
    const Eigen::Vector3d direction = (specimen.particles.position(i) - centre[k]).normalized();
    EXPECT_LT((direction - expected[k]).norm(), 1e-11);  // positions of 1e-3 m, arms of 1e-5 m
  }
}

TEST_P(Split, conserves_mass_and_books_what_is_lost_as_fines) {
  Specimen& specimen = scene_.specimen;
  const Specimen before = specimen;
  split(specimen, scene_.experiment, scene_.dynamics, scene_.failures);
  ASSERT_EQ(specimen.fines.size(), scene_.failures.size());
  for (std::size_t k = 0; k < scene_.failures.size(); ++k) {
    const auto p = static_cast<std::size_t>(scene_.failures[k].index);
    EXPECT_NEAR(specimen.fines[k].mass / before.particles.mass[p], 1.0 - kept_volume_fraction(GetParam()),
                1e-12);
    EXPECT_DOUBLE_EQ(specimen.fines[k].smallest_sibling,
                     2.0 * before.particles.body[p].radius * smallest_sibling_radius(GetParam()));
  }
  EXPECT_NEAR((particle_mass(specimen) + fines_mass(specimen)) / specimen.initial_mass, 1.0, 1e-12);
}

TEST_P(Split, leaves_the_shear_of_contacts_among_survivors_alone) {
  Specimen whole = scene_.specimen;
  Dynamics other(scene_.experiment, widest_kernels(), {});
  other.assess(whole);  // as the split does after it: turned into the tangent plane of the present positions
  split(scene_.specimen, scene_.experiment, scene_.dynamics, scene_.failures);
  const auto by_id = [](const Specimen& specimen) {
    std::map<std::pair<std::uint64_t, std::uint64_t>, Eigen::Vector3d> shears;
    for (const PairShear& pair : shear_history(specimen.contacts)) {
      shears[{specimen.particles.id[static_cast<std::size_t>(pair.first)],
              specimen.particles.id[static_cast<std::size_t>(pair.second)]}] = {pair.x, pair.y, pair.z};
    }
    return shears;
  };
  auto expected = by_id(whole);
  std::set<std::uint64_t> failed;
  for (const Failure& failure : scene_.failures)
    failed.insert(whole.particles.id[static_cast<std::size_t>(failure.index)]);
  std::erase_if(expected, [&](const auto& contact) {
    return failed.contains(contact.first.first) || failed.contains(contact.first.second);
  });
  EXPECT_GT(expected.size(), 20u);
  EXPECT_EQ(by_id(scene_.specimen), expected);  // bit for bit; siblings start without shear
}

std::string layout_name(const ::testing::TestParamInfo<SplitLayout>& info) {
  constexpr const char* kNames[] = {"octahedral", "cubic", "tetrahedral"};
  return kNames[static_cast<int>(info.param)];
}

INSTANTIATE_TEST_SUITE_P(Layouts, Split,
                         ::testing::Values(SplitLayout::kOctahedral, SplitLayout::kCubic,
                                           SplitLayout::kTetrahedral),
                         layout_name);

TEST(Splits, conserve_mass_and_spare_the_finest_through_many_generations) {
  const Experiment experiment = weak_sand(80);
  Dynamics dynamics(experiment, widest_kernels(), {});
  Specimen specimen = packed(experiment, dynamics);
  dynamics.let_fail(true);
  std::int32_t oldest = 0;
  for (int cycle = 0; cycle < 4000; ++cycle) {
    const CycleResult result = dynamics.cycle(specimen, isotropic(20e6, 2.0));
    for (const Failure& failure : result.failures) {
      const auto i = static_cast<std::size_t>(failure.index);
      EXPECT_GE(2.0 * specimen.particles.body[i].radius, experiment.material.comminution_limit);
      EXPECT_GT(failure.stress_ratio, 0.0);
      oldest = std::max(oldest, specimen.particles.generation[i]);
    }
    split(specimen, experiment, dynamics, result.failures);
  }
  EXPECT_GE(oldest, 1) << "no fragment broke again";
  EXPECT_GT(specimen.broken_total, 20);
  EXPECT_EQ(specimen.broken_total, static_cast<std::int64_t>(specimen.fines.size()));
  EXPECT_NEAR((particle_mass(specimen) + fines_mass(specimen)) / specimen.initial_mass, 1.0, 1e-12);
}

TEST(Splits, of_nothing_change_nothing) {
  AboutToBreak scene(weak_sand(80));
  const double step = scene.specimen.time_step;
  const std::size_t particles = scene.specimen.particles.size();
  split(scene.specimen, scene.experiment, scene.dynamics, {});
  EXPECT_EQ(scene.specimen.particles.size(), particles);
  EXPECT_EQ(scene.specimen.time_step, step);
}

}  // namespace
}  // namespace creep
