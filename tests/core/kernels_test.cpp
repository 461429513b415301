// Every vector kernel gives the bits of its plain twin.
#include "core/dem/kernels.h"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <limits>
#include <numbers>
#include <ostream>
#include <random>

#include "core/dem/contact_model.h"
#include "core/dem/contact_search.h"
#include "tests/core/dem_scenes.h"

namespace creep {
namespace {

std::uint64_t bits(double value) { return std::bit_cast<std::uint64_t>(value); }

Material smooth() {
  Material material;
  material.roughness = 0.0;
  return material;
}

/// Other roughness factors give the table another width of cell.
Material other_roughness() {
  Material material;
  material.roughness_n1 = 0.82;
  material.roughness_n2 = 1.24;
  return material;
}

Material turning(Material material) {
  material.free_rotation = true;
  return material;
}

std::vector<Material> materials() {
  return {Material{}, smooth(), other_roughness(), turning(Material{}), turning(smooth())};
}

std::vector<CycleKind> kinds() {
  std::vector<CycleKind> all;
  for (const bool measure : {false, true}) {
    for (const bool check : {false, true}) {
      for (const bool move : {false, true}) all.push_back({measure, check, move});
    }
  }
  return all;
}

/// Draws with the engine alone: std distributions differ between libraries.
class Draw {
 public:
  explicit Draw(std::uint64_t seed) : engine_(seed) {}
  double unit() { return static_cast<double>(engine_() >> 11) * 0x1p-53; }
  double between(double low, double high) { return low + (high - low) * unit(); }
  double log_between(double low, double high) { return low * std::exp(unit() * std::log(high / low)); }
  bool one_in(int n) { return engine_() % static_cast<std::uint64_t>(n) == 0; }
  Eigen::Vector3d direction() {
    Eigen::Vector3d v;
    do {
      v = {between(-1, 1), between(-1, 1), between(-1, 1)};
    } while (v.norm() > 1.0 || v.norm() < 0.1);
    return v.normalized();
  }

 private:
  std::mt19937_64 engine_;
};

/// Pairs of bodies that reach every branch of the law and of Coulomb's cap.
struct Pairs {
  Pairs(const ContactModel& model, const Material& material, std::size_t wanted, std::uint64_t seed) {
    Draw draw(seed);
    count = wanted;
    for (std::size_t c = 0; c < count; ++c) {
      // A particle with several contacts has them one after the other.
      if (c == 0 || draw.one_in(2)) {
        body.push_back({draw.between(0, 1e-3), draw.between(0, 1e-3), draw.between(0, 1e-3),
                        draw.log_between(10e-6, 200e-6), 0, 0, 0, limit(draw)});
        first.push_back(static_cast<std::int32_t>(body.size()) - 1);
      } else {
        first.push_back(first.back());
      }
      const Body& one = body[static_cast<std::size_t>(first.back())];
      const double r1 = one.radius, r2 = draw.log_between(10e-6, 200e-6);
      const double deepest = model.law.delta_T2() > 0.0 ? 1.5 * model.law.delta_T2() : 5e-6;
      double overlap = draw.log_between(1e-15, deepest);
      if (draw.one_in(6)) overlap = -overlap;
      if (draw.one_in(6)) overlap = draw.log_between(0.3 * deepest, deepest);
      if (draw.one_in(20)) overlap = model.law.delta_T1();
      const Eigen::Vector3d at(one.x, one.y, one.z);
      const Eigen::Vector3d n = draw.direction();
      const Eigen::Vector3d there = at + (r1 + r2 - overlap) * n;
      body.push_back({there.x(), there.y(), there.z(), r2, 0, 0, 0, limit(draw)});
      if (!draw.one_in(4)) {
        const Eigen::Vector3d v = draw.log_between(1e-8, 10.0) * draw.direction();
        body.back().vx = v.x();
        body.back().vy = v.y();
        body.back().vz = v.z();
      }
      second.push_back(static_cast<std::int32_t>(body.size()) - 1);
      root_radius.push_back(std::sqrt(r1 * r2 / (r1 + r2)));
      const double force =
          model.modulus * root_radius.back() * model.law.g(std::fabs(overlap)) * material.friction;
      const double size = draw.one_in(4) ? 0.0 : force * draw.between(0.0, 1.5);
      const Eigen::Vector3d old = size * draw.direction();
      shear_x.push_back(old.x());
      shear_y.push_back(old.y());
      shear_z.push_back(old.z());
    }
    // The list repeats its last pair up to the widest vector.
    const std::size_t padded = (count + 7) / 8 * 8;
    first.resize(padded, first.back());
    second.resize(padded, second.back());
    root_radius.resize(padded, root_radius.back());
    shear_x.resize(padded);
    shear_y.resize(padded);
    shear_z.resize(padded);
    force.resize(padded);
    couple.resize(padded);
    for (std::size_t i = 0; i < body.size(); ++i) {
      const Eigen::Vector3d w = (draw.one_in(4) ? 0.0 : draw.log_between(1e-3, 1e5)) * draw.direction();
      spin.push_back({w.x(), w.y(), w.z(), 0.0});
    }
    stress.resize(padded);
    resultant.resize(body.size());
    peak_stress.resize(body.size());
    // Some ends are left to the particle kernel; padding always.
    const bool shared = draw.one_in(2);
    for (std::size_t c = 0; c < count; ++c) {
      deferred.push_back(shared ? static_cast<std::uint8_t>(4.0 * draw.unit()) : std::uint8_t{0});
    }
    deferred.resize(padded, kDeferFirst | kDeferSecond);
  }

  static double limit(Draw& draw) {
    return draw.one_in(2) ? std::numeric_limits<double>::infinity()
                          : std::numbers::pi * draw.log_between(1e6, 1e11);
  }

  ContactPhase phase(const ContactModel& model, const Material& material, CycleKind kind) {
    ContactPhase phase;
    phase.body = body.data();
    phase.first = first.data();
    phase.second = second.data();
    phase.root_radius = root_radius.data();
    phase.shear_x = shear_x.data();
    phase.shear_y = shear_y.data();
    phase.shear_z = shear_z.data();
    phase.force = force.data();
    phase.resultant = resultant.data();
    phase.deferred = deferred.data();
    phase.stress = stress.data();
    phase.peak_stress = peak_stress.data();
    if (material.free_rotation) {
      phase.spin = spin.data();
      phase.couple = couple.data();
    }
    phase.law = model.view();
    phase.modulus = model.modulus;
    phase.tangential_ratio = model.tangential_ratio;
    phase.friction = material.friction;
    phase.drift = kind.move ? 1e-8 : 0.0;
    return phase;
  }

  ContactSums run(const Kernels& kernels, const ContactModel& model, const Material& material,
                  CycleKind kind) {
    ContactSums sums;
    kernels.contacts(phase(model, material, kind), kind, 0, count, sums);
    return sums;
  }

  AlignedVector<Body> body;
  std::vector<std::int32_t> first, second;
  AlignedVector<double> root_radius, shear_x, shear_y, shear_z, stress, peak_stress;
  AlignedVector<ContactForce> force, couple, resultant;
  AlignedVector<Spin> spin;
  std::vector<std::uint8_t> deferred;
  std::size_t count = 0;
};

void expect_same_pairs(const Pairs& a, const Pairs& b, CycleKind kind) {
  for (std::size_t c = 0; c < a.count; ++c) {
    ASSERT_EQ(bits(a.shear_x[c]), bits(b.shear_x[c])) << "contact " << c;
    ASSERT_EQ(bits(a.shear_y[c]), bits(b.shear_y[c])) << "contact " << c;
    ASSERT_EQ(bits(a.shear_z[c]), bits(b.shear_z[c])) << "contact " << c;
    ASSERT_EQ(bits(a.couple[c].x), bits(b.couple[c].x)) << "contact " << c;
    ASSERT_EQ(bits(a.couple[c].y), bits(b.couple[c].y)) << "contact " << c;
    ASSERT_EQ(bits(a.couple[c].z), bits(b.couple[c].z)) << "contact " << c;
    if (a.deferred[c] == 0) continue;  // the slots are not used
    if (kind.measure) {
      ASSERT_EQ(bits(a.stress[c]), bits(b.stress[c])) << "contact " << c;
      ASSERT_EQ(bits(a.force[c].stiffness), bits(b.force[c].stiffness)) << "contact " << c;
    }
    ASSERT_EQ(bits(a.force[c].x), bits(b.force[c].x)) << "contact " << c;
    ASSERT_EQ(bits(a.force[c].y), bits(b.force[c].y)) << "contact " << c;
    ASSERT_EQ(bits(a.force[c].z), bits(b.force[c].z)) << "contact " << c;
  }
  for (std::size_t i = 0; i < a.resultant.size(); ++i) {
    ASSERT_EQ(bits(a.resultant[i].x), bits(b.resultant[i].x)) << "particle " << i;
    ASSERT_EQ(bits(a.resultant[i].y), bits(b.resultant[i].y)) << "particle " << i;
    ASSERT_EQ(bits(a.resultant[i].z), bits(b.resultant[i].z)) << "particle " << i;
    ASSERT_EQ(bits(a.resultant[i].stiffness), bits(b.resultant[i].stiffness)) << "particle " << i;
    ASSERT_EQ(bits(a.peak_stress[i]), bits(b.peak_stress[i])) << "particle " << i;
  }
}

void expect_same_sums(const ContactSums& a, const ContactSums& b) {
  EXPECT_EQ(a.tangential_work, b.tangential_work);
  EXPECT_EQ(a.friction, b.friction);
  EXPECT_EQ(a.force, b.force);
  EXPECT_EQ(a.overlap, b.overlap);
  EXPECT_EQ(a.touching, b.touching);
  EXPECT_EQ(bits(a.largest_overlap_ratio), bits(b.largest_overlap_ratio));
  EXPECT_EQ(a.breaking, b.breaking);
}

struct InstructionSet {
  const char* name;
  const Kernels* (*kernels)();
  friend void PrintTo(const InstructionSet& set, std::ostream* out) { *out << set.name; }
};

class VectorKernels : public ::testing::TestWithParam<InstructionSet> {
 protected:
  void SetUp() override {
    kernels_ = GetParam().kernels();
    if (kernels_ == nullptr) GTEST_SKIP() << "NOT TESTED: this processor has no " << GetParam().name;
  }
  const Kernels* kernels_ = nullptr;
};

TEST_P(VectorKernels, contacts_have_the_bits_of_the_plain_twin) {
  std::int64_t slid = 0, stuck = 0, opened = 0, broke = 0;
  for (const Material& material : materials()) {
    const ContactModel model(material);
    for (const CycleKind kind : kinds()) {
      for (std::size_t count = 1; count <= 20; ++count) {
        for (std::uint64_t seed = 0; seed < 5; ++seed) {
          Pairs plain(model, material, count, 1000 * count + seed);
          Pairs vector = plain;
          const ContactSums expected = plain.run(portable_kernels(), model, material, kind);
          const ContactSums sums = vector.run(*kernels_, model, material, kind);
          ASSERT_NO_FATAL_FAILURE(expect_same_pairs(plain, vector, kind)) << count << " pairs, seed " << seed;
          expect_same_sums(expected, sums);
          slid += expected.friction > 0;
          stuck += expected.friction == 0 && expected.tangential_work != 0;
          opened += expected.touching < static_cast<std::int64_t>(count) && kind.measure;
          broke += expected.breaking;
        }
      }
    }
  }
  EXPECT_TRUE(slid > 100 && stuck > 100 && opened > 100 && broke > 100) << "some branch was not reached";
}

TEST_P(VectorKernels, contacts_in_shares_give_what_they_give_at_once) {
  const Material material;
  const ContactModel model(material);
  Pairs whole(model, material, 45, 7);
  Pairs shared = whole;
  const CycleKind kind{false, true, true};
  const ContactSums expected = whole.run(portable_kernels(), model, material, kind);
  const ContactPhase phase = shared.phase(model, material, kind);
  ContactSums sums;
  for (const auto& [begin, end] : {std::pair<std::size_t, std::size_t>{16, 32}, {32, 45}, {0, 16}}) {
    kernels_->contacts(phase, kind, begin, end, sums);
  }
  expect_same_pairs(whole, shared, kind);
  expect_same_sums(expected, sums);
}

TEST_P(VectorKernels, asking_for_memory_ahead_changes_no_bit) {
  const Material material;
  const ContactModel model(material);
  for (const bool measure : {false, true}) {
    Pairs plain(model, material, 1005, 11);
    Pairs asked = plain;
    const CycleKind kind{measure, true, true};
    const ContactSums expected = plain.run(portable_kernels(), model, material, kind);
    ContactPhase phase = asked.phase(model, material, kind);
    phase.ask_ahead = true;
    ContactSums sums;
    kernels_->contacts(phase, kind, 0, 1005, sums);
    expect_same_pairs(plain, asked, kind);
    expect_same_sums(expected, sums);
  }
}

/// A tight heap of grains of very unequal size, some of them against walls and beyond, with its list and
/// forces.
struct Heap {
  Heap(const ContactModel& contact_model, std::size_t count, std::uint64_t seed) : model(contact_model) {
    const Experiment experiment;
    Draw draw(seed);
    std::vector<testing::Ball> given;
    for (std::size_t i = 0; i < count; ++i) {
      testing::Ball ball{draw.between(0, 4e-4), draw.between(0, 4e-4), draw.between(0, 4e-4),
                         draw.log_between(20e-6, 150e-6)};
      if (draw.one_in(8)) ball.x = ball.radius - draw.log_between(1e-15, 2e-5);  // just touches wall 0
      if (!draw.one_in(4)) {
        const Eigen::Vector3d v = draw.log_between(1e-6, 1.0) * draw.direction();
        ball.vx = v.x();
        ball.vy = draw.one_in(5) ? 0.0 : v.y();
        ball.vz = draw.one_in(5) ? -0.0 : v.z();
      }
      given.push_back(ball);
    }
    specimen = testing::balls(experiment, 4e-4, given);
    specimen.time_step = 1e-8;
    for (Body& body : specimen.particles.body) {
      body.breaking_stress = Pairs::limit(draw);
    }
    ContactSearch search(2e-6);
    Team team(1);
    search.search(specimen, team, nullptr);
    Contacts& contacts = specimen.contacts;
    for (std::size_t c = 0; c < contacts.count; ++c) {
      const Eigen::Vector3d f = draw.log_between(1e-9, 10.0) * draw.direction();
      const double kind = draw.unit();
      if (kind < 0.2) continue;  // does not touch
      contacts.force[c] = {f.x(), f.y(), f.z(), draw.log_between(1e2, 1e7)};
      contacts.stress[c] = draw.log_between(1e5, 1e10);
    }
    for (std::size_t i = 0; i < count; ++i) {
      const Eigen::Vector3d f = draw.log_between(1e-9, 10.0) * draw.direction();
      contacts.resultant[i] = {f.x(), f.y(), f.z(), draw.one_in(4) ? 0.0 : draw.log_between(1e2, 1e7)};
      contacts.peak_stress[i] = draw.one_in(4) ? 0.0 : draw.log_between(1e5, 1e10);
      contacts.shared[i] = draw.one_in(3) ? 1 : 0;
    }
    contacts.special.clear();
    for (std::size_t i = 0; i < count; ++i) {
      if (contacts.shared[i] != 0 || contacts.near_walls[i] != 0)
        contacts.special.push_back(static_cast<std::int32_t>(i));
    }
    breaking.assign(count, 0.0);
  }

  ParticleSums run(const Kernels& kernels, CycleKind kind, double damping, bool rubs = false) {
    Contacts& contacts = specimen.contacts;
    ParticlePhase phase;
    phase.body = specimen.particles.body.data();
    phase.force = contacts.force.data();
    phase.resultant = contacts.resultant.data();
    phase.shared = contacts.shared.data();
    phase.stress = contacts.stress.data();
    phase.peak_stress = contacts.peak_stress.data();
    phase.own_begin = contacts.own_begin.data();
    phase.lower_begin = contacts.lower_begin.data();
    phase.lower_contact = contacts.lower_contact.data();
    phase.near_walls = contacts.near_walls.data();
    phase.special = contacts.special.data();
    phase.special_count = contacts.special.size();
    phase.reference = contacts.reference.data();
    phase.inertial_mass = specimen.particles.inertial_mass.data();
    phase.mobilised_stress = specimen.particles.mobilised_stress.data();
    phase.breaking = breaking.data();
    std::copy(specimen.walls.position.begin(), specimen.walls.position.end(), phase.wall_position);
    if (rubs) {
      specimen.particles.wall_shear.resize(specimen.particles.size(),
                                           {{{1e-4, -2e-4}, {0.5, 0.0}, {0.0, -1e-5}}});
      phase.wall_shear = specimen.particles.wall_shear.data();
    }
    phase.wall_friction = 0.3;
    phase.tangential_ratio = 0.9;
    phase.last_drift = 1e-8;
    phase.law = model.view();
    phase.wall_modulus = model.wall_modulus;
    phase.local_damping = damping;
    phase.kick = 0.9e-8;
    phase.drift = 1e-8;
    phase.floor_stiffness = 1e4;
    ParticleSums sums;
    kernels.particles(phase, kind, 0, specimen.particles.size(), sums);
    return sums;
  }

  const ContactModel& model;
  Specimen specimen;
  std::vector<double> breaking;
};

void expect_same_heaps(const Heap& a, const Heap& b, CycleKind kind) {
  for (std::size_t i = 0; i < a.specimen.particles.size(); ++i) {
    const Body &p = a.specimen.particles.body[i], &q = b.specimen.particles.body[i];
    ASSERT_EQ(bits(p.x), bits(q.x)) << "particle " << i;
    ASSERT_EQ(bits(p.y), bits(q.y)) << "particle " << i;
    ASSERT_EQ(bits(p.z), bits(q.z)) << "particle " << i;
    ASSERT_EQ(bits(p.radius), bits(q.radius)) << "particle " << i;
    ASSERT_EQ(bits(p.vx), bits(q.vx)) << "particle " << i;
    ASSERT_EQ(bits(p.vy), bits(q.vy)) << "particle " << i;
    ASSERT_EQ(bits(p.vz), bits(q.vz)) << "particle " << i;
    ASSERT_EQ(bits(p.breaking_stress), bits(q.breaking_stress)) << "particle " << i;
    ASSERT_EQ(bits(a.specimen.particles.mobilised_stress[i]), bits(b.specimen.particles.mobilised_stress[i]));
    ASSERT_EQ(bits(a.breaking[i]), bits(b.breaking[i])) << "particle " << i;
    ASSERT_EQ(a.specimen.particles.wall_shear.empty(), b.specimen.particles.wall_shear.empty());
    if (!a.specimen.particles.wall_shear.empty()) {
      const auto &left = a.specimen.particles.wall_shear[i].across,
                 &right = b.specimen.particles.wall_shear[i].across;
      for (std::size_t axis = 0; axis < 3; ++axis)
        for (std::size_t k = 0; k < 2; ++k)
          ASSERT_EQ(bits(left[axis][k]), bits(right[axis][k])) << "particle " << i;
    }
    for (const Heap* heap : {&a, &b}) {
      const ContactForce& left = heap->specimen.contacts.resultant[i];
      ASSERT_TRUE(left.x == 0.0 && left.y == 0.0 && left.z == 0.0 && left.stiffness == 0.0)
          << "not cleared for the next cycle";
      if (kind.measure) {
        ASSERT_EQ(heap->specimen.contacts.peak_stress[i], 0.0);
      }
    }
  }
}

TEST_P(VectorKernels, particles_have_the_bits_of_the_plain_twin) {
  int at_walls = 0, broke = 0, slid = 0;
  for (const Material& material : materials()) {
    const ContactModel model(material);
    for (const CycleKind kind : kinds()) {
      for (std::size_t count = 1; count <= 20; ++count) {
        for (const auto& [damping, rubs] : {std::pair(0.0, false), {0.7, false}, {0.7, true}}) {
          Heap plain(model, count, 31 * count);
          Heap vector(model, count, 31 * count);
          const ParticleSums expected = plain.run(portable_kernels(), kind, damping, rubs);
          const ParticleSums sums = vector.run(*kernels_, kind, damping, rubs);
          ASSERT_NO_FATAL_FAILURE(expect_same_heaps(plain, vector, kind)) << count << " particles";
          for (std::size_t w = 0; w < 6; ++w) {
            EXPECT_EQ(expected.wall_force[w], sums.wall_force[w]);
            EXPECT_EQ(expected.wall_stiffness[w], sums.wall_stiffness[w]);
            at_walls += expected.wall_force[w] != 0;
          }
          EXPECT_EQ(expected.tangential_work, sums.tangential_work);
          EXPECT_EQ(expected.friction, sums.friction);
          slid += expected.friction != 0;
          EXPECT_EQ(expected.damping, sums.damping);
          EXPECT_EQ(expected.list_ends, sums.list_ends);
          EXPECT_EQ(expected.resultant, sums.resultant);
          EXPECT_EQ(expected.with_contacts, sums.with_contacts);
          EXPECT_EQ(bits(expected.largest_stiffness_over_mass), bits(sums.largest_stiffness_over_mass));
          EXPECT_EQ(expected.finite, sums.finite);
          EXPECT_EQ(expected.breaking, sums.breaking);
          broke += expected.breaking;
        }
      }
    }
  }
  EXPECT_TRUE(at_walls > 100 && broke > 10 && slid > 100) << "some branch was not reached";
}

TEST_P(VectorKernels, see_a_position_that_is_no_longer_a_number) {
  const ContactModel model{Material{}};
  Heap heap(model, 11, 3);
  heap.specimen.particles.body[6].vy = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(heap.run(*kernels_, {true, false, true}, 0.7).finite);
  EXPECT_FALSE(heap.run(portable_kernels(), {true, false, true}, 0.7).finite);
}

INSTANTIATE_TEST_SUITE_P(InstructionSets, VectorKernels,
                         ::testing::Values(InstructionSet{"avx2", &avx2_kernels},
                                           InstructionSet{"avx512", &avx512_kernels}),
                         [](const auto& info) { return std::string(info.param.name); });

TEST(Kernels, other_roughness_factors_give_the_table_other_cells) {
  EXPECT_NE(ContactModel(other_roughness()).view().cell_shift, ContactModel(Material{}).view().cell_shift);
}

}  // namespace
}  // namespace creep
