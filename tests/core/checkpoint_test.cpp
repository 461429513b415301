// A damaged checkpoint is refused, never loaded and never a crash.
#include <gtest/gtest.h>

#include <fstream>
#include <random>
#include <sstream>

#include "core/experiment/experiment_toml.h"
#include "core/run/run.h"
#include "core/run/self_test.h"
#include "core/state/checkpoint.h"
#include "tests/core/run_scene.h"

namespace creep {
namespace {

using testing::short_job;
using testing::started;

/// A run in its second dynamic stage: contacts, fines and every clock are there.
const std::string& sound() {
  static const std::string checkpoint = [] {
    const std::unique_ptr<Run> run = started(short_job());
    while (run->progress().phase != Phase::kAgeing) run->advance(1000000);
    run->advance(100);
    return run->checkpoint();
  }();
  return checkpoint;
}

void expect_refused(const std::string& bytes, const std::string& what) {
  const auto state = read_checkpoint(bytes);
  ASSERT_FALSE(state.ok()) << what;
  ASSERT_TRUE(absl::IsDataLoss(state.status())) << what << ": " << state.status();
  ASSERT_TRUE(absl::IsDataLoss(read_checkpoint_info(bytes).status())) << what;
}

TEST(Checkpoint, is_refused_at_every_truncated_length) {
  const std::string& whole = sound();
  ASSERT_TRUE(read_checkpoint(whole).ok());
  for (std::size_t length = 0; length < whole.size(); ++length) {
    ASSERT_NO_FATAL_FAILURE(expect_refused(whole.substr(0, length), "length " + std::to_string(length)));
  }
}

TEST(Checkpoint, is_refused_with_any_byte_flipped) {
  std::mt19937_64 engine(11);
  const std::string& whole = sound();
  for (int k = 0; k < 400; ++k) {
    std::string damaged = whole;
    // Half of the flips among the heads at the front.
    std::size_t at = engine() % (k % 2 == 0 ? whole.size() : 300);
    if (at == 8 || at == 9) at = 10;  // another version number is for the next test
    damaged[at] = static_cast<char>(damaged[at] ^ (1 << (engine() % 8)));
    ASSERT_NO_FATAL_FAILURE(expect_refused(damaged, "bit flipped in byte " + std::to_string(at)));
    // Bits flipped in transit are damage, whatever they hit.
    const auto resumed = Run::resume(short_job(), {}, damaged);
    ASSERT_TRUE(absl::IsDataLoss(resumed.status())) << "byte " << at << ": " << resumed.status();
  }
}

TEST(Checkpoint, of_a_newer_program_is_refused_by_name_and_not_called_damaged) {
  std::string newer = sound();
  newer[8] = static_cast<char>(kCheckpointVersion + 1);
  // What a newer program keeps in it is unknown here.
  newer.replace(40, 8, "whatever");
  const auto info = read_checkpoint_info(newer);
  EXPECT_TRUE(absl::IsFailedPrecondition(info.status())) << info.status();
  EXPECT_NE(info.status().message().find("was made by a newer program"), absl::string_view::npos);
  EXPECT_TRUE(absl::IsFailedPrecondition(read_checkpoint(newer).status()));
  EXPECT_TRUE(absl::IsFailedPrecondition(Run::resume(short_job(), {}, newer).status()));
}

TEST(Checkpoint, is_refused_with_bytes_behind_it_or_of_something_else) {
  expect_refused(sound() + "x", "a byte behind");
  expect_refused(sound() + sound(), "twice");
  expect_refused("", "empty");
  expect_refused(std::string(100000, '\0'), "zeros");
  expect_refused("CREEPCK\n", "magic alone");
  std::mt19937_64 engine(1);
  for (int k = 0; k < 100; ++k) {
    std::string noise = "CREEPCK\n";
    for (int byte = 0; byte < 500; ++byte) noise.push_back(static_cast<char>(engine()));
    expect_refused(noise, "noise");
  }
}

TEST(Checkpoint, of_another_experiment_is_refused) {
  Experiment other = short_job();
  other.material.friction = 0.3;
  EXPECT_TRUE(absl::IsInvalidArgument(Run::resume(other, {}, sound()).status()));
  Experiment renamed = short_job();
  renamed.name = "the same physics";
  renamed.numerics.skin = 3e-6;
  EXPECT_TRUE(Run::resume(renamed, {}, sound()).ok()) << "name and skin change no result";
}

TEST(Checkpoint, tells_where_it_was_made) {
  const auto info = read_checkpoint_info(sound());
  ASSERT_TRUE(info.ok()) << info.status();
  const auto run = Run::resume(short_job(), {}, sound());
  ASSERT_TRUE(run.ok()) << run.status();
  EXPECT_EQ(info->format_version, kCheckpointVersion);
  EXPECT_EQ(info->arithmetic_id, arithmetic_id(""));
  EXPECT_EQ(info->experiment_hash, experiment_hash(short_job()));
  EXPECT_EQ(info->state_digest, (*run)->state_digest());
  EXPECT_EQ(info->next_sequence, (*run)->next_sequence());
  EXPECT_EQ(info->stage, "creep");
  EXPECT_EQ(info->particles, (*run)->progress().particles);
  EXPECT_GT(info->cycle, 1000);
  EXPECT_GT(info->age, 0.0);
  EXPECT_GT(info->dynamic_time, 0.0);
  EXPECT_GT(info->creep_time, info->age);
  EXPECT_GT(info->axial_strain, 0.0);
  EXPECT_GT(info->broken_total, 0);
  EXPECT_FALSE(info->inexact);
}

TEST(Checkpoint, made_with_other_arithmetic_needs_a_word_and_leaves_a_mark) {
  // A checkpoint that is whole but claims another arithmetic.
  const auto info = read_checkpoint_info(sound());
  const auto state = read_checkpoint(sound());
  ASSERT_TRUE(info.ok() && state.ok());
  CheckpointInfo foreign = *info;
  foreign.arithmetic_id = "0123456789abcdef";
  const std::string checkpoint = write_checkpoint(*state, foreign);
  EXPECT_TRUE(absl::IsFailedPrecondition(Run::resume(short_job(), {}, checkpoint).status()));
  RunOptions options;
  options.allow_inexact = true;
  const auto run = Run::resume(short_job(), options, checkpoint);
  ASSERT_TRUE(run.ok()) << run.status();
  EXPECT_TRUE((*run)->inexact());
  EXPECT_TRUE(read_checkpoint_info((*run)->checkpoint())->inexact);
}

class OldCheckpoint : public ::testing::TestWithParam<std::uint32_t> {};

TEST_P(OldCheckpoint, is_read) {
  std::ifstream file(CREEP_SOURCE_DIR "/tests/core/checkpoint_v" + std::to_string(GetParam()) + ".bin",
                     std::ios::binary);
  std::ostringstream old;
  old << file.rdbuf();
  const auto info = read_checkpoint_info(old.str());
  ASSERT_TRUE(info.ok()) << info.status();
  EXPECT_EQ(info->format_version, GetParam());
  const auto state = read_checkpoint(old.str());
  ASSERT_TRUE(state.ok()) << state.status();
  EXPECT_EQ(digest_of(*state), info->state_digest);
  if (GetParam() == 1) {
    ASSERT_TRUE(state->hold);
    EXPECT_EQ(state->hold->next_snapshot_age, Hold::kFirstSnapshotAge);
  }
  EXPECT_EQ(state->specimen.particles.spin.empty(), GetParam() != 4) << "only that file has grains that turn";
  EXPECT_TRUE(state->specimen.particles.wall_shear.empty());
  EXPECT_EQ(state->specimen.walls.carried, (std::array<double, 3>{}));
  const auto rewritten = read_checkpoint_info(write_checkpoint(*state, *info));
  ASSERT_TRUE(rewritten.ok()) << rewritten.status();
  EXPECT_EQ(rewritten->format_version, kCheckpointVersion);
  EXPECT_EQ(rewritten->state_digest, info->state_digest);
}

INSTANTIATE_TEST_SUITE_P(Versions, OldCheckpoint, ::testing::Values(1u, 2u, 3u, 4u, 5u, 6u, 7u));

TEST(Checkpoint, keeps_the_spins_of_grains_that_may_turn) {
  Experiment experiment = short_job();
  experiment.material.free_rotation = true;
  const std::unique_ptr<creep::Run> run = started(experiment);
  while (run->progress().stage == "packing") run->advance(1000000);
  run->advance(1000);
  const std::string checkpoint = run->checkpoint();
  const auto state = read_checkpoint(checkpoint);
  ASSERT_TRUE(state.ok()) << state.status();
  ASSERT_EQ(state->specimen.particles.spin.size(), state->specimen.particles.size());
  EXPECT_NE(state->specimen.particles.spin.back().x, 0.0);
  const auto resumed = Run::resume(experiment, {}, checkpoint);
  ASSERT_TRUE(resumed.ok()) << resumed.status();
  run->advance(500);
  (*resumed)->advance(500);
  EXPECT_EQ((*resumed)->state_digest(), run->state_digest());
  EXPECT_TRUE(absl::IsInvalidArgument(Run::resume(short_job(), {}, checkpoint).status()));
}

TEST(Checkpoint, keeps_the_forces_of_walls_that_rub) {
  Experiment experiment = short_job();
  experiment.material.wall_friction = 0.2;
  const std::unique_ptr<creep::Run> run = started(experiment);
  while (run->progress().stage == "packing") run->advance(1000000);
  run->advance(1000);
  const std::string checkpoint = run->checkpoint();
  const auto state = read_checkpoint(checkpoint);
  ASSERT_TRUE(state.ok()) << state.status();
  ASSERT_EQ(state->specimen.particles.wall_shear.size(), state->specimen.particles.size());
  RunState other = *state;
  for (WallShear& shear : other.specimen.particles.wall_shear) shear = {};
  EXPECT_NE(digest_of(other), digest_of(*state)) << "some wall rubs, and the digest tells";
  const auto resumed = Run::resume(experiment, {}, checkpoint);
  ASSERT_TRUE(resumed.ok()) << resumed.status();
  run->advance(500);
  (*resumed)->advance(500);
  EXPECT_EQ((*resumed)->state_digest(), run->state_digest());
  EXPECT_TRUE(absl::IsInvalidArgument(Run::resume(short_job(), {}, checkpoint).status()));
}

TEST(Checkpoint, keeps_the_velocity_of_walls_that_follow_their_specimen) {
  const std::unique_ptr<creep::Run> run = started(testing::triaxial_job());
  while (run->progress().stage != "triaxial") run->advance(1000000);
  run->advance(300);
  const std::string checkpoint = run->checkpoint();
  const auto state = read_checkpoint(checkpoint);
  ASSERT_TRUE(state.ok()) << state.status();
  EXPECT_NE(state->specimen.walls.carried[0], 0.0);
  EXPECT_EQ(state->specimen.walls.carried[2], 0.0) << "the axis is driven";
  RunState other = *state;
  other.specimen.walls.carried[0] = 0.0;
  EXPECT_NE(digest_of(other), digest_of(*state));
  EXPECT_EQ(write_checkpoint(*state, *read_checkpoint_info(checkpoint)), checkpoint);
}

/// Of the job below, at the beginning of its hold, by the last program that wrote version 2.
TEST(Checkpoint, of_version_2_goes_on_to_the_end_that_its_own_program_reached) {
  const ParseResult job = parse_experiment(R"(
[specimen]
particles = 20
void_ratio = 1.2
[[program]]
stage = "oedometric"
until = { axial_stress = "3 MPa" }
[[program]]
stage = "creep"
duration = "1 d"
[material]
limit_stress = "1.5 GPa"
comminution_limit = "0.06 mm"
[numerics]
minimum_cycles = 400
breakages_per_ageing = 1
loading_velocity = "0.5 m/s"
settle_tolerance = 0.02
unbalanced_tolerance = 0.01
)");
  ASSERT_TRUE(job.experiment);
  std::ifstream file(CREEP_SOURCE_DIR "/tests/core/checkpoint_v2.bin", std::ios::binary);
  std::ostringstream old;
  old << file.rdbuf();
  ASSERT_EQ(read_checkpoint_info(old.str())->format_version, 2u);
  // arithmetic_id has another number since: its self-test is another. What it stands for is the same.
  RunOptions options;
  options.allow_inexact = true;
  auto run = Run::resume(*job.experiment, options, old.str());
  ASSERT_TRUE(run.ok()) << run.status();
  Batch batch;
  do {
    batch = (*run)->advance(1000000);
    for (const Record& record : batch.records) {
      if (record.kind != RecordKind::kSample) continue;
      EXPECT_GT(record.values[column_index(RecordKind::kSample, "creep_time_s")], 0.0) << "a hold all along";
    }
  } while (!batch.outcome);
  EXPECT_EQ((*run)->state_digest(), "ecf8f1ff95e168accccee8e7e7d178cc7f1935927192074e9d544c4bcba5c46b");
  Experiment next = *job.experiment;
  next.start = Start{"another job", ""};
  EXPECT_TRUE(absl::IsInvalidArgument(Run::start_from(next, options, old.str()).status()))
      << "it does not say of which specimen it is";
}

/// Of the job below, each in another act, by the last program that wrote version 7.
class InEveryAct : public ::testing::TestWithParam<const char*> {};

TEST_P(InEveryAct, version_7_goes_on_to_the_end_of_an_undisturbed_run) {
  const ParseResult job = parse_experiment(R"(
[specimen]
particles = 30
seed = 4
void_ratio = 1.2
[[program]]
stage = "oedometric"
until = { axial_stress = "3 MPa" }
[[program]]
stage = "creep"
duration = "1 d"
[[program]]
stage = "triaxial"
until = { deviatoric_stress = "4 MPa" }
axial_velocity = "0.5 m/s"
keep = { every_axial_strain = 0.002 }
[[program]]
stage = "unload"
until = { deviatoric_stress = "0.5 MPa" }
[[program]]
stage = "relaxation"
duration = "1 h"
[material]
limit_stress = "1.5 GPa"
comminution_limit = "0.06 mm"
[numerics]
minimum_cycles = 400
breakages_per_ageing = "adaptive"
drift_tolerance = 0.1
loading_velocity = "0.5 m/s"
settle_tolerance = 0.02
unbalanced_tolerance = 0.01
local_damping = 0.7
)");
  ASSERT_TRUE(job.experiment);
  std::ifstream file(std::string(CREEP_SOURCE_DIR "/tests/core/checkpoint_v7") + GetParam() + ".bin",
                     std::ios::binary);
  std::ostringstream old;
  old << file.rdbuf();
  ASSERT_EQ(read_checkpoint_info(old.str())->format_version, 7u);
  RunOptions options;
  options.allow_inexact = true;  // arithmetic_id may get another number with its self-test
  const auto run = Run::resume(*job.experiment, options, old.str());
  ASSERT_TRUE(run.ok()) << run.status();
  // What is read is written anew, and goes on from there.
  const auto again = Run::resume(*job.experiment, options, (*run)->checkpoint());
  ASSERT_TRUE(again.ok()) << again.status();
  Batch batch;
  do {
    batch = (*again)->advance(1000000);
  } while (!batch.outcome);
  EXPECT_EQ(batch.outcome->reason, "completed");
  EXPECT_EQ((*again)->state_digest(), "6ac2a50221d928ff40804549dc1bead7a1cb09d5a14522d5bb5b476e9121d77e");
  EXPECT_EQ((*again)->next_sequence(), 939u) << "as many records as without a break";
}

INSTANTIATE_TEST_SUITE_P(Acts, InEveryAct,
                         ::testing::Values("_packing", "_loading", "", "_ageing", "_between", "_triaxial",
                                           "_unload", "_relaxation"));

TEST(Checkpoint, reads_back_every_bit_it_wrote) {
  const auto info = read_checkpoint_info(sound());
  const auto state = read_checkpoint(sound());
  ASSERT_TRUE(info.ok() && state.ok());
  EXPECT_EQ(write_checkpoint(*state, *info), sound());
}

}  // namespace
}  // namespace creep
