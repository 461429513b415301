// Pictures of a specimen: what stands in them, when they are taken, and that nothing disturbs their bytes.
#include "core/output/snapshot.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <string>
#include <vector>

#include "absl/strings/escaping.h"
#include "absl/strings/numbers.h"
#include "core/dem/measures.h"
#include "tests/core/dem_scenes.h"
#include "tests/core/run_scene.h"

namespace creep {
namespace {

using testing::short_job;
using testing::started;

Experiment pictured_job() {
  Experiment experiment = short_job();
  // Jumps that stay below 1 s, skip decades, stay in one.
  experiment.numerics.loading_velocity = 0.5;
  experiment.program.back() = CreepStage{3e8, {}};
  experiment.output.snapshots_per_decade = true;
  return experiment;
}

/// The value of an attribute behind a place in the text.
std::string attribute(const std::string& text, const std::string& name, std::size_t from = 0) {
  const std::size_t begin = text.find(" " + name + "=\"", from);
  if (begin == std::string::npos) return "";
  const std::size_t value = begin + name.size() + 3;
  return text.substr(value, text.find('"', value) - value);
}

/// The numbers of a binary DataArray: the first 8 bytes must tell the length of the rest.
std::vector<std::uint64_t> words(const std::string& text, const std::string& name, const std::string& type) {
  const std::size_t at = text.find("Name=\"" + name + "\"");
  EXPECT_NE(at, std::string::npos) << name;
  if (at == std::string::npos) return {};
  const std::size_t element = text.rfind('<', at);
  EXPECT_EQ(attribute(text, "type", element), type) << name;
  EXPECT_EQ(attribute(text, "format", element), "binary") << name;
  const std::size_t begin = text.find('>', at) + 1;
  std::string bytes;
  EXPECT_TRUE(absl::Base64Unescape(text.substr(begin, text.find('<', begin) - begin), &bytes)) << name;
  std::vector<std::uint64_t> values;
  for (std::size_t at_byte = 0; at_byte + 8 <= bytes.size(); at_byte += 8) {
    std::uint64_t value = 0;
    for (std::size_t i = 0; i < 8; ++i)
      value |= std::uint64_t{static_cast<unsigned char>(bytes[at_byte + i])} << (8 * i);
    values.push_back(value);
  }
  EXPECT_EQ(bytes.size() % 8, 0u) << name;
  EXPECT_FALSE(values.empty()) << name;
  if (values.empty()) return {};
  EXPECT_EQ(values.front(), bytes.size() - 8) << name;
  values.erase(values.begin());
  return values;
}

std::vector<double> doubles(const std::string& text, const std::string& name) {
  std::vector<double> values;
  for (const std::uint64_t word : words(text, name, "Float64")) values.push_back(std::bit_cast<double>(word));
  return values;
}

std::vector<std::uint64_t> integers(const std::string& text, const std::string& name) {
  return words(text, name, "Int64");
}

std::size_t count_of(const std::string& text, const std::string& what) {
  std::int64_t count = -1;
  EXPECT_TRUE(absl::SimpleAtoi(attribute(text, what), &count)) << what;
  return static_cast<std::size_t>(count);
}

/// Crushed and assessed: the shear forces belong to the positions.
struct Crushed {
  Crushed() : dynamics(experiment, testing::widest_kernels(), {}) {
    state.specimen = testing::packed(experiment, dynamics);
    dynamics.let_fail(true);
    testing::run_cycles(state.specimen, experiment, dynamics, testing::oedometric(3e6, 2.0), 4000);
    keep_forces();
    dynamics.assess(state.specimen);
    for (Snapshot& snapshot : snapshots(state, experiment, dynamics.model()))
      (snapshot.name.starts_with("particles") ? particles : contacts) = std::move(snapshot.bytes);
  }

  /// As if each particle's contacts fell to different threads: all forces go to slots then.
  void keep_forces() {
    dynamics.ensure_list(state.specimen);
    Contacts& list = state.specimen.contacts;
    std::fill(list.deferred.begin(), list.deferred.end(), std::uint8_t{kDeferFirst | kDeferSecond});
    std::fill(list.shared.begin(), list.shared.end(), std::uint8_t{1});
    list.special.resize(list.shared.size());
    std::iota(list.special.begin(), list.special.end(), 0);
  }

  Experiment experiment = testing::weak_sand(80);
  Dynamics dynamics;
  RunState state;
  std::string particles, contacts;
};

const Crushed& crushed() {
  static const Crushed scene;
  return scene;
}

TEST(Snapshot, holds_every_particle_as_it_is) {
  const Particles& particles = crushed().state.specimen.particles;
  const std::string& text = crushed().particles;
  ASSERT_GT(crushed().state.specimen.broken_total, 0);
  const std::size_t n = particles.size();
  EXPECT_EQ(count_of(text, "NumberOfPoints"), n);
  EXPECT_EQ(count_of(text, "NumberOfVerts"), n);
  EXPECT_EQ(count_of(text, "NumberOfLines"), 0u);
  const auto id = integers(text, "id"), parent = integers(text, "parent"),
             generation = integers(text, "generation");
  const auto centre = doubles(text, "Points"), velocity = doubles(text, "velocity"),
             radius = doubles(text, "radius"), diameter = doubles(text, "diameter_mm"),
             limit = doubles(text, "limit_stress_Pa"), crack = doubles(text, "crack_ratio");
  for (const std::size_t size : {id.size(), parent.size(), generation.size(), centre.size() / 3,
                                 velocity.size() / 3, radius.size(), diameter.size(), crack.size()}) {
    ASSERT_EQ(size, n);
  }
  for (std::size_t i = 0; i < n; ++i) {
    const Body& body = particles.body[i];
    ASSERT_EQ(id[i], particles.id[i]);
    ASSERT_EQ(parent[i], particles.parent[i]);
    ASSERT_EQ(generation[i], static_cast<std::uint64_t>(particles.generation[i]));
    ASSERT_EQ(centre[3 * i], body.x);
    ASSERT_EQ(centre[3 * i + 2], body.z);
    ASSERT_EQ(velocity[3 * i + 1], body.vy);
    ASSERT_EQ(radius[i], body.radius);
    ASSERT_DOUBLE_EQ(diameter[i], 2000.0 * body.radius);
    ASSERT_EQ(limit[i], particles.limit_stress[i]);
    ASSERT_EQ(crack[i], particles.crack[i] / body.radius);
  }
  const std::string cells = text.substr(text.find("<Verts>"));
  EXPECT_EQ(integers(cells, "connectivity").size(), n);
  EXPECT_EQ(integers(cells, "offsets").back(), n);
}

TEST(Snapshot, has_the_stresses_of_a_measuring_cycle) {
  const Particles& particles = crushed().state.specimen.particles;
  const auto stress = doubles(crushed().particles, "mobilised_stress_Pa");
  const auto ratio = doubles(crushed().particles, "stress_ratio");
  ASSERT_EQ(stress.size(), particles.size());
  std::size_t loaded = 0;
  for (std::size_t i = 0; i < particles.size(); ++i) {
    ASSERT_EQ(stress[i], particles.mobilised_stress[i]) << "particle " << i;
    ASSERT_EQ(ratio[i], stress[i] / particles.limit_stress[i]);
    loaded += stress[i] > 0.0;
  }
  EXPECT_GT(loaded, particles.size() / 2);
}

TEST(Snapshot, holds_every_contact_between_particles) {
  const Specimen& specimen = crushed().state.specimen;
  const std::string& text = crushed().contacts;
  const std::string cells = text.substr(text.find("<Lines>"));
  const auto ends = integers(cells, "connectivity");
  const auto normal = doubles(text, "normal_force_N"), shear = doubles(text, "shear_force_N"),
             overlap = doubles(text, "overlap_m");
  const auto sliding = integers(text, "sliding");
  ASSERT_EQ(count_of(text, "NumberOfPoints"), specimen.particles.size());
  EXPECT_EQ(count_of(text, "NumberOfVerts"), 0u);
  ASSERT_EQ(count_of(text, "NumberOfLines"), normal.size());
  ASSERT_EQ(ends.size(), 2 * normal.size());
  ASSERT_EQ(integers(cells, "offsets").back(), ends.size());
  std::size_t k = 0, slide = 0;
  for (std::size_t c = 0; c < specimen.contacts.count; ++c) {
    const auto first = static_cast<std::size_t>(specimen.contacts.first[c]);
    const auto second = static_cast<std::size_t>(specimen.contacts.second[c]);
    const double gap = (specimen.particles.position(first) - specimen.particles.position(second)).norm() -
                       specimen.particles.body[first].radius - specimen.particles.body[second].radius;
    if (gap >= 0.0) continue;
    ASSERT_LT(k, normal.size());
    ASSERT_EQ(ends[2 * k], first);
    ASSERT_EQ(ends[2 * k + 1], second);
    // A difference of lengths of 1e-4 m leaves their rounding, 1e-20 m.
    ASSERT_NEAR(overlap[k], -gap, 1e-19);
    // The slot has both forces; they are at right angles. Rounding alone.
    const ContactForce& force = specimen.contacts.force[c];
    const double whole = std::sqrt(force.x * force.x + force.y * force.y + force.z * force.z);
    ASSERT_NEAR(std::hypot(normal[k], shear[k]), whole, 1e-12 * whole);
    ASSERT_LE(shear[k], specimen.friction * normal[k]);
    // At the limit the kernel has just cut the force down to it; rounding of the rotation alone.
    const bool at_limit = shear[k] > (1.0 - 1e-12) * specimen.friction * normal[k];
    if (at_limit) {
      ASSERT_EQ(sliding[k], 1u);
    }
    slide += sliding[k];
    ++k;
  }
  EXPECT_EQ(k, normal.size());
  EXPECT_GT(slide, 0u);
  EXPECT_LT(slide, k);
}

TEST(Snapshot, tells_when_it_was_taken) {
  RunState state = crushed().state;
  state.act = DynamicStage{};
  state.stage = 1;
  state.hold = Hold{};
  state.hold->ageing_jumps = 7;
  state.next_sequence = 123456789012;
  state.specimen.clocks = {.age = 0.1, .dynamic_time = 1.0 / 3.0, .suspended_time = 0.0, .hold_start = 0.3};
  const auto pictures = snapshots(state, short_job(), crushed().dynamics.model());
  ASSERT_EQ(pictures.size(), 2u);
  EXPECT_EQ(pictures[0].name, "particles_02_creep_0007.vtp");
  EXPECT_EQ(pictures[1].name, "contacts_02_creep_0007.vtp");
  for (const Snapshot& picture : pictures) {
    const auto head = read_snapshot_head(picture.bytes);
    ASSERT_TRUE(head.ok()) << head.status();
    EXPECT_EQ(head->age, 0.1);
    EXPECT_EQ(head->dynamic_time, 1.0 / 3.0);
    EXPECT_EQ(head->creep_time, state.specimen.clocks.creep_time());
    EXPECT_EQ(head->next_sequence, 123456789012u);
    for (const std::size_t length : {std::size_t{0}, std::size_t{100}, picture.bytes.find("next_sequence")}) {
      EXPECT_TRUE(absl::IsDataLoss(read_snapshot_head(picture.bytes.substr(0, length)).status())) << length;
    }
  }
}

struct Pictures {
  std::vector<Snapshot> taken;
  std::vector<Record> records;
  std::string digest;
};

/// Runs to the end; after every `step` cycles it goes on from a checkpoint if `killed`.
Pictures pictures_of(const Experiment& experiment, const RunOptions& options, std::int64_t step,
                     bool killed) {
  Pictures pictures;
  std::unique_ptr<creep::Run> run = started(experiment, options);
  for (;;) {
    Batch batch = run->advance(step);
    for (Snapshot& snapshot : batch.snapshots) pictures.taken.push_back(std::move(snapshot));
    for (Record& record : batch.records) pictures.records.push_back(std::move(record));
    if (batch.outcome) break;
    if (!killed) continue;
    auto resumed = Run::resume(experiment, options, run->checkpoint());
    EXPECT_TRUE(resumed.ok()) << resumed.status();
    run = *std::move(resumed);
  }
  pictures.digest = run->state_digest();
  return pictures;
}

const Pictures& undisturbed() {
  static const Pictures pictures = pictures_of(pictured_job(), {}, 1000000, false);
  return pictures;
}

TEST(Snapshot, is_taken_at_stage_ends_and_after_each_new_decade_of_age) {
  // What ought to be there, from the records: a dynamic stage ends with a sample and a row of stages.csv.
  std::vector<std::string> expected = {"00_packing", "01_oedometric"};
  std::string last;
  double passed = -1.0;  // decade, log10
  const Record* sample = nullptr;
  for (const Record& record : undisturbed().records) {
    if (record.kind == RecordKind::kSample) sample = &record;
    const auto value = [&](const char* column) {
      return sample->values[column_index(RecordKind::kSample, column)];
    };
    if (record.kind != RecordKind::kStage || value("phase") != static_cast<double>(Phase::kDynamicStage))
      continue;
    const std::string number = std::to_string(static_cast<int>(value("dynamic_stage")));
    last = "02_creep_" + std::string(4 - number.size(), '0') + number;
    const double decade = std::floor(std::log10(value("age_s")));  // -infinity before the first jump
    if (decade > passed) expected.push_back(last);
    passed = std::max(decade, passed);
  }
  if (expected.back() != last) expected.push_back(last);
  ASSERT_GE(expected.size(), 4u) << "no decade but the last has a picture";
  std::vector<std::string> names;
  for (const std::string& label : expected) {
    names.push_back("particles_" + label + ".vtp");
    names.push_back("contacts_" + label + ".vtp");
  }
  std::vector<std::string> taken;
  for (const Snapshot& snapshot : undisturbed().taken) taken.push_back(snapshot.name);
  EXPECT_EQ(taken, names);
}

TEST(Snapshot, has_the_same_bytes_whatever_disturbs_the_run) {
  const auto expect_the_same = [](const Pictures& pictures, const std::string& what) {
    EXPECT_EQ(pictures.digest, undisturbed().digest) << what;
    ASSERT_EQ(pictures.taken.size(), undisturbed().taken.size()) << what;
    for (std::size_t k = 0; k < pictures.taken.size(); ++k) {
      EXPECT_EQ(pictures.taken[k].name, undisturbed().taken[k].name) << what;
      EXPECT_TRUE(pictures.taken[k].bytes == undisturbed().taken[k].bytes)
          << what << ", " << pictures.taken[k].name;
    }
  };
  RunOptions often, portable;
  often.rebuild_every = 7;
  portable.instruction_set = "portable";
  expect_the_same(pictures_of(pictured_job(), {}, 997, true), "killed every 997 cycles");
  expect_the_same(pictures_of(pictured_job(), often, 5000, false), "rebuilt every 7 cycles");
  expect_the_same(pictures_of(pictured_job(), portable, 5000, true), "portable");
  Experiment wide = pictured_job();
  wide.numerics.skin = 0.1 * median_diameter(wide.specimen.grading);
  expect_the_same(pictures_of(wide, {}, 1000000, false), "ten times the skin");
}

TEST(Snapshot, is_not_taken_unasked_and_changes_no_bit_of_the_run) {
  Experiment unasked = pictured_job();
  unasked.output.snapshots_per_decade = false;
  const Pictures none = pictures_of(unasked, {}, 1000000, false);
  EXPECT_TRUE(none.taken.empty());
  EXPECT_EQ(none.digest, undisturbed().digest);
}

}  // namespace
}  // namespace creep
