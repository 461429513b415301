// The determinism contract (core/README.md): the same bits whatever may differ between two attempts.
#include <gtest/gtest.h>

#include <algorithm>
#include <iostream>
#include <set>

#include "core/run/run.h"
#include "core/run/self_test.h"
#include "core/state/state.h"
#include "tests/core/run_scene.h"

namespace creep {
namespace {

using testing::finish;
using testing::short_job;
using testing::started;
using testing::Trace;
using testing::whole_run;

/// state_digest at the end of short_job(), seed 1. It changes only in a commit of its own, which gives the
/// physics reason.
constexpr const char* kGoldenDigest = "4e8a0774d4867bf26d94533857b101a24c9251375f775510f3678d406e3123c9";

/// The undisturbed run that the others are held against.
const Trace& undisturbed() {
  static const Trace trace = whole_run(short_job());
  return trace;
}

void expect_the_same(const Trace& trace, const std::string& what) {
  EXPECT_EQ(trace.digest, undisturbed().digest) << what;
  EXPECT_EQ(trace.outcome, undisturbed().outcome) << what;
  ASSERT_EQ(trace.records.size(), undisturbed().records.size()) << what;
  for (std::size_t k = 0; k < trace.records.size(); ++k) {
    ASSERT_EQ(trace.records[k], undisturbed().records[k]) << what << ", record " << k;
  }
}

double last_sample(const Trace& trace, std::string_view column) {
  for (auto row = trace.records.rbegin(); row != trace.records.rend(); ++row) {
    const auto record = decode(*row);
    if (record->kind == RecordKind::kSample) return record->values[column_index(RecordKind::kSample, column)];
  }
  return -1.0;
}

TEST(Determinism, the_scene_crushes_and_ages) {
  EXPECT_EQ(undisturbed().outcome, "completed");
  EXPECT_GE(last_sample(undisturbed(), "broken_total"), 5);
  EXPECT_GE(last_sample(undisturbed(), "dynamic_stage"), 2);
  EXPECT_GT(last_sample(undisturbed(), "age_s"), 80000.0);
}

TEST(Determinism, the_golden_digest_holds_in_every_build) { EXPECT_EQ(undisturbed().digest, kGoldenDigest); }

/// A few hundred cycles of a run: where they start and what they end with.
struct Leg {
  std::string name;
  std::string checkpoint;
  std::vector<std::string> records;
  std::string digest;
};

// Short, because threads on busy processors wait for each other most of the time.
constexpr std::int64_t kLegCycles = 300;

Leg next_leg(creep::Run& run, std::string name) {
  Leg leg{std::move(name), run.checkpoint(), {}, {}};
  for (const Record& record : run.advance(kLegCycles).records) leg.records.push_back(encode(record));
  leg.digest = run.state_digest();
  return leg;
}

bool breaks(const Leg& leg) {
  return std::any_of(leg.records.begin(), leg.records.end(),
                     [](const std::string& row) { return decode(row)->kind == RecordKind::kBreakage; });
}

TEST(Determinism, threads_do_not_change_a_bit) {
  const Experiment experiment = short_job();
  const std::unique_ptr<creep::Run> alone = started(experiment);
  std::vector<Leg> legs = {next_leg(*alone, "packing")};
  while (alone->progress().stage == "packing") alone->advance(1000000);
  do {
    if (legs.size() > 1) legs.pop_back();
    legs.push_back(next_leg(*alone, "loading until grains break"));
  } while (!breaks(legs.back()));
  while (alone->progress().phase != Phase::kAgeing) alone->advance(1000000);
  legs.push_back(next_leg(*alone, "ageing and what follows"));
  ASSERT_TRUE(breaks(legs.back()));
  for (const int threads : {2, 3}) {
    RunOptions options;
    options.threads = threads;
    for (const Leg& expected : legs) {
      auto run = creep::Run::resume(experiment, options, expected.checkpoint);
      ASSERT_TRUE(run.ok()) << run.status();
      const Leg leg = next_leg(**run, expected.name);
      EXPECT_EQ(leg.records, expected.records) << threads << " threads, " << leg.name;
      EXPECT_EQ(leg.digest, expected.digest) << threads << " threads, " << leg.name;
    }
  }
}

TEST(Determinism, the_rebuild_schedule_does_not_change_a_bit) {
  for (const std::int64_t every : {1, 7}) {
    RunOptions options;
    options.rebuild_every = every;
    expect_the_same(whole_run(short_job(), options), "rebuilt every " + std::to_string(every));
  }
}

TEST(Determinism, the_skin_does_not_change_a_bit) {
  for (const double factor : {0.5, 2.0, 10.0}) {
    Experiment experiment = short_job();
    experiment.numerics.skin = factor * 0.01 * median_diameter(experiment.specimen.grading);
    expect_the_same(whole_run(experiment), "skin times " + std::to_string(factor));
  }
}

TEST(Determinism, the_instruction_set_does_not_change_a_bit) {
  for (const char* set : {"portable", "avx2", "avx512"}) {
    if (!choose_instruction_set(set).ok()) {
      std::cout << "NOT TESTED: this processor has no " << set << "\n";
      continue;
    }
    RunOptions options;
    options.instruction_set = set;
    expect_the_same(whole_run(short_job(), options), set);
  }
}

/// What the undisturbed run does not have. @param least_broken  so many grains break in it
void expect_every_bit_kept(const Experiment& experiment, double least_broken) {
  const Trace usual = whole_run(experiment);
  EXPECT_NE(usual.digest, undisturbed().digest);
  EXPECT_GE(last_sample(usual, "broken_total"), least_broken) << "grains must break";
  RunOptions plain, rebuilt;
  plain.instruction_set = "portable";
  rebuilt.rebuild_every = 1;
  for (const RunOptions& options : {plain, rebuilt}) {
    const Trace other = whole_run(experiment, options);
    EXPECT_EQ(other.digest, usual.digest) << options.instruction_set;
    EXPECT_EQ(other.records, usual.records) << options.instruction_set;
  }
  const std::unique_ptr<creep::Run> alone = started(experiment);
  while (alone->progress().stage == "packing") alone->advance(1000000);
  const Leg expected = next_leg(*alone, "loading");
  RunOptions threads;
  threads.threads = 3;
  auto run = creep::Run::resume(experiment, threads, expected.checkpoint);
  ASSERT_TRUE(run.ok()) << run.status();
  EXPECT_EQ(next_leg(**run, "loading").digest, expected.digest);
}

TEST(Determinism, grains_that_turn_keep_every_bit_too) {
  Experiment experiment = short_job();
  experiment.material.free_rotation = true;
  expect_every_bit_kept(experiment, 3);
}

TEST(Determinism, grains_that_walls_rub_keep_every_bit_too) {
  Experiment experiment = short_job();
  experiment.material.wall_friction = 0.2;
  expect_every_bit_kept(experiment, 3);
  experiment.material.free_rotation = true;
  expect_every_bit_kept(experiment, 3);
}

TEST(Determinism, arithmetic_id_is_that_of_the_portable_kernels) {
  const std::string portable = arithmetic_id("portable");
  EXPECT_EQ(portable.size(), 16u);
  for (const char* set : {"avx2", "avx512"}) {
    if (choose_instruction_set(set).ok()) {
      EXPECT_EQ(arithmetic_id(set), portable) << set;
    } else {
      std::cout << "NOT TESTED: this processor has no " << set << "\n";
    }
  }
}

TEST(Determinism, the_cycle_budget_does_not_change_a_bit) {
  for (const std::int64_t budget : {1, 500}) {
    expect_the_same(whole_run(short_job(), {}, budget), "budget " + std::to_string(budget));
  }
}

/// Kills the run after each of the given numbers of cycles and resumes it from the checkpoint made there.
TEST(Determinism, a_resumed_run_goes_on_as_if_nothing_had_happened) {
  // Prime steps, so that kills come at any phase of measuring and of the time step: in packing, loading,
  // dynamic stages; the last advance() of a stage ends early, so that some come between stages and before
  // ageing.
  std::set<std::string> killed_in;
  for (const std::int64_t step : {997, 4999}) {
    const Experiment experiment = short_job();
    std::unique_ptr<creep::Run> run = started(experiment);
    Trace trace;
    bool done = false;
    while (!done) {
      const Batch batch = run->advance(step);
      for (const Record& record : batch.records) {
        ASSERT_EQ(record.sequence, trace.records.size());
        trace.records.push_back(encode(record));
      }
      killed_in.insert(run->progress().stage + " " + std::string(phase_name(run->progress().phase)));
      if (batch.outcome) {
        trace.outcome = batch.outcome->reason;
        trace.digest = run->state_digest();
        done = true;
        continue;
      }
      const std::string checkpoint = run->checkpoint();
      const std::string digest = run->state_digest();
      auto resumed = creep::Run::resume(experiment, {}, checkpoint);
      ASSERT_TRUE(resumed.ok()) << resumed.status();
      run = *std::move(resumed);
      ASSERT_EQ(run->state_digest(), digest);
      ASSERT_EQ(run->next_sequence(), trace.records.size());
      ASSERT_FALSE(run->inexact());
    }
    expect_the_same(trace, "killed every " + std::to_string(step));
  }
  EXPECT_EQ(killed_in.size(), 4u) << "packing, loading, dynamic stage, ageing";
}

TEST(Determinism, a_run_resumed_right_after_an_ageing_jump_goes_on_the_same) {
  const Experiment experiment = short_job();
  std::unique_ptr<creep::Run> run = started(experiment);
  Trace trace;
  for (;;) {
    const Batch batch = run->advance(1000000);
    ASSERT_FALSE(batch.outcome);
    for (const Record& record : batch.records) trace.records.push_back(encode(record));
    if (run->progress().phase == Phase::kAgeing) break;
  }
  // The jump and the first cycle after it.
  const Batch batch = run->advance(1);
  ASSERT_EQ(batch.cycles, 1);
  for (const Record& record : batch.records) trace.records.push_back(encode(record));
  ASSERT_EQ(run->progress().phase, Phase::kDynamicStage);
  auto resumed = creep::Run::resume(experiment, {}, run->checkpoint());
  ASSERT_TRUE(resumed.ok()) << resumed.status();
  finish(**resumed, trace);
  expect_the_same(trace, "resumed after ageing");
}

TEST(Determinism, another_seed_gives_other_bits) {
  Experiment experiment = short_job();
  experiment.specimen.seed = 2;
  EXPECT_NE(whole_run(experiment).digest, undisturbed().digest);
}

}  // namespace
}  // namespace creep
