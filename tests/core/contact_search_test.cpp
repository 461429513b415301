// The neighbour search finds what a brute force finds, and no memory of a contact is lost on the way.
#include "core/dem/contact_search.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <ostream>
#include <random>
#include <set>

#include "core/dem/shear_history.h"
#include "core/dem/splitter.h"
#include "tests/core/dem_scenes.h"

namespace creep {
namespace {

using testing::Ball;
using testing::balls;

constexpr double kSkin = 2e-6;
constexpr double kSide = 1e-3;

using PairSet = std::set<std::pair<std::int32_t, std::int32_t>>;

double random(std::mt19937_64& engine, double low, double high) {
  return low + (high - low) * static_cast<double>(engine() >> 11) * 0x1p-53;
}

/// Grains anywhere in the box, and `beyond` of its side outside.
Specimen cloud(std::size_t count, double smallest, double largest, double beyond, std::uint64_t seed) {
  std::mt19937_64 engine(seed);
  std::vector<Ball> given;
  for (std::size_t i = 0; i < count; ++i) {
    const double low = -beyond * kSide, high = (1.0 + beyond) * kSide;
    Ball ball{random(engine, low, high), random(engine, low, high), random(engine, low, high), 0.0};
    ball.radius = smallest * std::exp(random(engine, 0.0, 1.0) * std::log(largest / smallest));
    given.push_back(ball);
  }
  Specimen specimen = balls(Experiment{}, kSide, given);
  specimen.time_step = 1e-8;
  return specimen;
}

/// Pairs whose gap is below the skin: grains at rest reach half a skin each.
PairSet brute_force(const Specimen& specimen) {
  PairSet pairs;
  const auto& body = specimen.particles.body;
  for (std::size_t i = 0; i < body.size(); ++i) {
    for (std::size_t j = i + 1; j < body.size(); ++j) {
      const double dx = body[j].x - body[i].x, dy = body[j].y - body[i].y, dz = body[j].z - body[i].z;
      if (std::sqrt(dx * dx + dy * dy + dz * dz) < body[i].radius + body[j].radius + kSkin) {
        pairs.insert({static_cast<std::int32_t>(i), static_cast<std::int32_t>(j)});
      }
    }
  }
  return pairs;
}

PairSet listed(const Contacts& contacts) {
  PairSet pairs;
  for (std::size_t c = 0; c < contacts.count; ++c) pairs.insert({contacts.first[c], contacts.second[c]});
  return pairs;
}

/// Rows, their mirror and the padding, as specimen.h promises them.
void expect_well_formed(const Specimen& specimen) {
  const Contacts& contacts = specimen.contacts;
  const std::size_t n = specimen.particles.size();
  ASSERT_EQ(contacts.own_begin.size(), n + 1);
  ASSERT_EQ(contacts.lower_begin.size(), n + 1);
  ASSERT_EQ(contacts.lower_contact.size(), contacts.count);
  ASSERT_EQ(contacts.first.size() % 8, 0u);
  for (std::size_t c = 1; c < contacts.count; ++c) {
    ASSERT_LT(std::pair(contacts.first[c - 1], contacts.second[c - 1]),
              std::pair(contacts.first[c], contacts.second[c]));
  }
  for (std::size_t i = 0; i < n; ++i) {
    for (std::int32_t c = contacts.own_begin[i]; c < contacts.own_begin[i + 1]; ++c) {
      ASSERT_EQ(contacts.first[static_cast<std::size_t>(c)], static_cast<std::int32_t>(i));
    }
    for (std::int32_t k = contacts.lower_begin[i]; k < contacts.lower_begin[i + 1]; ++k) {
      const auto c = static_cast<std::size_t>(contacts.lower_contact[static_cast<std::size_t>(k)]);
      ASSERT_EQ(contacts.second[c], static_cast<std::int32_t>(i));
    }
  }
}

struct Cloud {
  const char* name;
  std::size_t count;
  double smallest, largest;  // radius [m]
  double beyond;
  friend void PrintTo(const Cloud& cloud, std::ostream* out) { *out << cloud.name; }
};

class ContactSearchOn : public ::testing::TestWithParam<Cloud> {};

TEST_P(ContactSearchOn, finds_exactly_the_pairs_of_a_brute_force) {
  const Cloud& scene = GetParam();
  for (std::uint64_t seed = 0; seed < 5; ++seed) {
    Specimen specimen = cloud(scene.count, scene.smallest, scene.largest, scene.beyond, seed);
    ContactSearch search(kSkin);
    Team team(1);
    search.search(specimen, team, nullptr);
    EXPECT_EQ(listed(specimen.contacts), brute_force(specimen)) << "seed " << seed;
    ASSERT_NO_FATAL_FAILURE(expect_well_formed(specimen));
    EXPECT_TRUE(specimen.contacts.valid);
  }
}

TEST_P(ContactSearchOn, makes_the_same_list_with_any_number_of_threads) {
  const Cloud& scene = GetParam();
  Specimen one = cloud(scene.count, scene.smallest, scene.largest, scene.beyond, 9);
  ContactSearch search(kSkin);
  Team team(1);
  search.search(one, team, nullptr);
  for (const int threads : {2, 3}) {
    Specimen many = cloud(scene.count, scene.smallest, scene.largest, scene.beyond, 9);
    ContactSearch other(kSkin);
    Team others(threads);
    other.search(many, others, nullptr);
    EXPECT_EQ(many.contacts.first, one.contacts.first);
    EXPECT_EQ(many.contacts.second, one.contacts.second);
    EXPECT_EQ(many.contacts.own_begin, one.contacts.own_begin);
    EXPECT_EQ(many.contacts.lower_begin, one.contacts.lower_begin);
    EXPECT_EQ(many.contacts.lower_contact, one.contacts.lower_contact);
    EXPECT_EQ(many.contacts.near_walls, one.contacts.near_walls);
  }
}

INSTANTIATE_TEST_SUITE_P(Clouds, ContactSearchOn,
                         ::testing::Values(Cloud{"one_size", 600, 50e-6, 50e-6, 0.0},
                                           Cloud{"sizes_one_to_fifteen", 800, 10e-6, 150e-6, 0.0},
                                           Cloud{"sizes_one_to_five_hundred", 800, 0.4e-6, 200e-6, 0.0},
                                           Cloud{"a_single_grain", 1, 50e-6, 60e-6, 0.0},
                                           Cloud{"two_grains", 2, 400e-6, 500e-6, 0.0},
                                           Cloud{"no_grain_touches", 20, 1e-6, 2e-6, 0.0},
                                           Cloud{"beyond_the_box", 500, 20e-6, 80e-6, 0.3}),
                         [](const auto& info) { return std::string(info.param.name); });

TEST(ContactSearch, no_grain_can_reach_one_that_it_is_not_listed_with) {
  // Fast grains have a reach of their own; what holds is: as long as each stays within it, every touching
  // pair is listed.
  std::mt19937_64 engine(5);
  Specimen specimen = cloud(500, 10e-6, 100e-6, 0.0, 3);
  for (std::size_t i = 0; i < 500; i += 7) specimen.particles.body[i].vx = random(engine, -20.0, 20.0);
  ContactSearch search(kSkin);
  Team team(2);
  search.search(specimen, team, nullptr);
  const PairSet pairs = listed(specimen.contacts);
  for (int shake = 0; shake < 20; ++shake) {
    for (std::size_t i = 0; i < 500; ++i) {
      const ListReference& from = specimen.contacts.reference[i];
      Eigen::Vector3d way(random(engine, -1, 1), random(engine, -1, 1), random(engine, -1, 1));
      way *= 0.999 * std::sqrt(from.reach_squared) / way.norm();
      Body& body = specimen.particles.body[i];
      body.x = from.x + way.x();
      body.y = from.y + way.y();
      body.z = from.z + way.z();
    }
    const auto& body = specimen.particles.body;
    for (std::int32_t i = 0; i < 500; ++i) {
      for (std::int32_t j = i + 1; j < 500; ++j) {
        const auto a = static_cast<std::size_t>(i), b = static_cast<std::size_t>(j);
        const double distance = (specimen.particles.position(a) - specimen.particles.position(b)).norm();
        if (distance < body[a].radius + body[b].radius) {
          ASSERT_TRUE(pairs.contains({i, j}));
        }
      }
      for (std::size_t w = 0; w < 6; ++w) {
        // The walls may come half a skin closer.
        const auto a = static_cast<std::size_t>(i);
        const double along = specimen.particles.position(a)[static_cast<Eigen::Index>(w / 2)];
        const double gap = w % 2 == 0 ? along : kSide - along;
        if (gap - 0.499 * kSkin < body[a].radius) {
          ASSERT_TRUE(specimen.contacts.near_walls[a] >> w & 1) << "grain " << i << " wall " << w;
        }
      }
    }
  }
}

/// Gives every contact a shear force of its own.
void fill_shear(Contacts& contacts) {
  for (std::size_t c = 0; c < contacts.count; ++c) {
    contacts.shear_x[c] = 1.0 + static_cast<double>(c);
    contacts.shear_y[c] = -2.0 - static_cast<double>(c);
    contacts.shear_z[c] = 0.5 * static_cast<double>(c);
  }
}

TEST(ContactSearch, carries_shear_over_when_grains_go_and_come) {
  for (const int threads : {1, 3}) {
    Specimen specimen = cloud(300, 30e-6, 120e-6, 0.0, 11);
    ContactSearch search(kSkin);
    Team team(threads);
    search.search(specimen, team, nullptr);
    fill_shear(specimen.contacts);
    const std::vector<PairShear> before = shear_history(specimen.contacts);
    // Every ninth goes; three come at the end.
    Particles& particles = specimen.particles;
    const Particles old = particles;
    std::vector<std::int32_t> new_index(old.size());
    particles.body.clear();
    for (std::size_t i = 0; i < old.size(); ++i) {
      new_index[i] = i % 9 == 4 ? -1 : static_cast<std::int32_t>(particles.body.size());
      if (new_index[i] >= 0) particles.body.push_back(old.body[i]);
    }
    for (std::size_t k = 0; k < 3; ++k) particles.body.push_back(old.body[9 * k + 4]);
    search.search(specimen, team, &new_index);

    EXPECT_EQ(listed(specimen.contacts), brute_force(specimen));
    std::vector<PairShear> expected;
    for (PairShear pair : before) {
      pair.first = new_index[static_cast<std::size_t>(pair.first)];
      pair.second = new_index[static_cast<std::size_t>(pair.second)];
      if (pair.first >= 0 && pair.second >= 0) expected.push_back(pair);
    }
    const std::vector<PairShear> after = shear_history(specimen.contacts);
    ASSERT_EQ(after.size(), expected.size());
    for (std::size_t k = 0; k < after.size(); ++k) {
      EXPECT_EQ(after[k].first, expected[k].first);
      EXPECT_EQ(after[k].second, expected[k].second);
      EXPECT_EQ(after[k].x, expected[k].x);
      EXPECT_EQ(after[k].y, expected[k].y);
      EXPECT_EQ(after[k].z, expected[k].z);
    }
  }
}

TEST(ContactSearch, keeps_the_list_right_among_fragments_of_a_crushing_specimen) {
  Experiment experiment = testing::weak_sand(60);
  experiment.numerics.skin = kSkin;
  Dynamics dynamics(experiment, testing::widest_kernels(), {});
  Specimen specimen = scatter(experiment);
  specimen.friction = experiment.material.friction;
  dynamics.assess(specimen);
  dynamics.let_fail(true);
  const WallControl control = testing::isotropic(5e6, 20.0);
  for (int cycle = 0; cycle < 1500; ++cycle) {
    testing::run_cycles(specimen, experiment, dynamics, control, 1);
    if (cycle % 50 != 0) continue;
    dynamics.ensure_list(specimen);
    const PairSet pairs = listed(specimen.contacts);
    const auto& body = specimen.particles.body;
    for (std::size_t i = 0; i < body.size(); ++i) {
      for (std::size_t j = i + 1; j < body.size(); ++j) {
        if ((specimen.particles.position(i) - specimen.particles.position(j)).norm() <
            body[i].radius + body[j].radius) {
          const auto pair = std::pair(static_cast<std::int32_t>(i), static_cast<std::int32_t>(j));
          ASSERT_TRUE(pairs.contains(pair)) << "cycle " << cycle;
        }
      }
    }
  }
  EXPECT_GT(specimen.broken_total, 5);
}

}  // namespace
}  // namespace creep
