// The stages of a program, from isotropic loading to relaxation, and programs that start from a checkpoint.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "core/dem/particle_birth.h"
#include "core/physics/grading.h"
#include "core/run/run.h"
#include "core/state/checkpoint.h"
#include "tests/core/run_scene.h"

namespace creep {
namespace {

using testing::finish;
using testing::kKeptStrainStep;
using testing::started;
using testing::Trace;
using testing::triaxial_job;
using testing::whole_run;

/// state_digest at the end of triaxial_job(), seed 1. It changes only in a commit of its own, which gives the
/// physics reason.
constexpr const char* kGoldenDigest = "476fb9e77ac74b12a4809cd753db1ee34e505feb5a2b97cb6287ce3789bd2596";

const Trace& undisturbed() {
  static const Trace trace = whole_run(triaxial_job());
  return trace;
}

std::vector<Record> rows(const Trace& trace, RecordKind kind, double stage) {
  std::vector<Record> found;
  for (const std::string& bytes : trace.records) {
    const auto record = decode(bytes);
    if (record->kind != kind) continue;
    if (record->values[column_index(kind, "stage")] == stage) found.push_back(*record);
  }
  return found;
}

double value(const Record& record, std::string_view column) {
  return record.values[column_index(record.kind, column)];
}

double q(const Record& sample) { return value(sample, "deviatoric_stress_Pa"); }

/// The sample at the end of a stage.
Record end_of(double stage) { return rows(undisturbed(), RecordKind::kSample, stage).back(); }

TEST(Program, summary_has_the_relative_breakage_between_first_and_last_grading_curve) {
  const Experiment experiment = testing::short_job();
  const std::unique_ptr<creep::Run> run = started(experiment);
  Trace trace;
  finish(*run, trace);
  std::map<double, std::vector<double>> curves;
  std::vector<double> diameters, ultimate;
  for (const std::string& bytes : trace.records) {
    const auto record = decode(bytes);
    if (record->kind != RecordKind::kGrading) continue;
    const double number = value(*record, "curve");
    curves[number].push_back(value(*record, "passing"));
    if (number != 0.0) continue;
    diameters.push_back(value(*record, "diameter_m"));
    // The coarsest grain of few is finer than the end of the grading.
    ultimate.push_back(fractal_passing(
        diameters.back(), stratified_diameters(experiment.specimen.grading, 80).back(), 0.01e-3, 0.4));
  }
  ASSERT_GT(curves.size(), 2u);
  const std::vector<double>&first = curves.begin()->second, &last = curves.rbegin()->second;
  std::map<std::string, double> figures;
  for (const SummaryFigure& figure : run->summary()) figures[figure.name] = figure.value;
  // Radii are grown to their size by products, masses are sums: rounding.
  EXPECT_NEAR(figures.at("breakage_hardin"), breakage_hardin(diameters, first, last), 1e-10);
  EXPECT_NEAR(figures.at("breakage_einav"), breakage_einav(diameters, first, last, ultimate), 1e-10);
  EXPECT_GT(figures.at("breakage_hardin"), 0.01);
}

TEST(Program, isotropic_loading_ends_at_rest_with_the_stress_on_all_walls) {
  ASSERT_EQ(undisturbed().outcome, "completed");
  const Record end = end_of(0);
  // settle_tolerance of the job
  EXPECT_NEAR(value(end, "axial_stress_Pa"), 1e6, 0.02e6);
  EXPECT_NEAR(value(end, "radial_stress_Pa"), 1e6, 0.02e6);
  EXPECT_LT(value(end, "unbalanced_force_ratio"), 1e-2);
  EXPECT_EQ(value(rows(undisturbed(), RecordKind::kStage, 0).back(), "settled"), 1.0);
  EXPECT_GT(value(end, "volumetric_strain"), value(end, "axial_strain"));
}

TEST(Program, triaxial_loading_ends_as_it_passes_its_deviatoric_stress) {
  EXPECT_GE(q(end_of(1)), 0.5e6);
  for (const Record& sample : rows(undisturbed(), RecordKind::kSample, 1)) {
    if (sample.sequence == end_of(1).sequence) break;
    EXPECT_LT(q(sample), 0.5e6);
  }
}

TEST(Program, creep_holds_the_deviatoric_stress_reached_and_relaxation_the_strain) {
  for (const Record& end : rows(undisturbed(), RecordKind::kStage, 2)) {
    EXPECT_NEAR(value(end, "axial_stress_end_Pa"), 1.5e6, 0.02 * 1.5e6);
  }
  EXPECT_NEAR(value(end_of(2), "radial_stress_Pa"), 1e6, 0.02e6);
  EXPECT_GE(value(end_of(2), "creep_time_s"), 3600.0);
  const std::vector<Record> relaxing = rows(undisturbed(), RecordKind::kSample, 3);
  for (const Record& sample : relaxing) {
    // The walls stop where the creep stage left them: the strain is that of its end, bit for bit.
    EXPECT_EQ(value(sample, "axial_strain"), value(relaxing.front(), "axial_strain"));
  }
  EXPECT_GE(value(relaxing.back(), "creep_time_s"), 3600.0);
  EXPECT_LE(value(relaxing.back(), "axial_stress_Pa"), value(end_of(2), "axial_stress_Pa"));
}

TEST(Program, unloading_goes_down_and_reloading_up_again) {
  EXPECT_NEAR(q(end_of(4)), 0.1e6, 0.02 * 1.1e6 + 0.02e6);
  EXPECT_LT(value(end_of(4), "unbalanced_force_ratio"), 1e-2);
  EXPECT_GE(value(end_of(5), "axial_strain"), 0.15);
  EXPECT_NEAR(value(end_of(6), "axial_stress_Pa"), 1.3e6, 0.02 * 1.3e6);
  EXPECT_NEAR(value(end_of(7), "axial_stress_Pa"), 0.5e6, 0.01e6);
  EXPECT_NEAR(value(end_of(7), "radial_stress_Pa"), 0.5e6, 0.01e6);
}

TEST(Program, the_golden_digest_holds_in_every_build) { EXPECT_EQ(undisturbed().digest, kGoldenDigest); }

void expect_the_same(const Trace& trace, const std::string& what) {
  EXPECT_EQ(trace.digest, undisturbed().digest) << what;
  EXPECT_EQ(trace.outcome, undisturbed().outcome) << what;
  ASSERT_EQ(trace.records.size(), undisturbed().records.size()) << what;
  for (std::size_t k = 0; k < trace.records.size(); ++k) {
    ASSERT_EQ(trace.records[k], undisturbed().records[k]) << what << ", record " << k;
  }
  ASSERT_EQ(trace.kept.size(), undisturbed().kept.size()) << what;
  for (std::size_t k = 0; k < trace.kept.size(); ++k) {
    EXPECT_EQ(trace.kept[k].name, undisturbed().kept[k].name);
    EXPECT_TRUE(trace.kept[k].bytes == undisturbed().kept[k].bytes) << what << ", " << trace.kept[k].name;
  }
}

TEST(Program, killed_and_resumed_in_every_stage_it_goes_on_as_if_nothing_had_happened) {
  std::set<std::int64_t> killed_in;
  const Experiment experiment = triaxial_job();
  std::unique_ptr<creep::Run> run = started(experiment);
  Trace trace;
  for (bool done = false; !done;) {
    const Batch batch = run->advance(1009);
    for (const Record& record : batch.records) trace.records.push_back(encode(record));
    trace.kept.insert(trace.kept.end(), batch.kept.begin(), batch.kept.end());
    killed_in.insert(run->progress().stage_index);
    done = batch.outcome.has_value();
    if (done) {
      trace.outcome = batch.outcome->reason;
      trace.digest = run->state_digest();
    } else {
      auto resumed = creep::Run::resume(experiment, {}, run->checkpoint());
      ASSERT_TRUE(resumed.ok()) << resumed.status();
      run = *std::move(resumed);
    }
  }
  expect_the_same(trace, "killed every 1009 cycles");
  EXPECT_EQ(killed_in.size(), 9U) << "packing and eight stages";
}

TEST(Program, rebuilds_and_skin_do_not_change_a_bit) {
  RunOptions options;
  options.rebuild_every = 7;
  Experiment experiment = triaxial_job();
  experiment.numerics.skin = 3.0 * 0.01 * median_diameter(experiment.specimen.grading);
  expect_the_same(whole_run(experiment, options), "rebuilt every 7 cycles with three times the skin");
}

const std::map<std::string, std::string>& kept() {
  static const std::map<std::string, std::string> kAll = [] {
    std::map<std::string, std::string> by_name;
    for (const KeptCheckpoint& one : undisturbed().kept) by_name[one.name] = one.bytes;
    return by_name;
  }();
  return kAll;
}

TEST(Program, checkpoints_are_kept_at_each_step_and_at_the_end) {
  const auto& all = kept();
  EXPECT_EQ(all.size(), undisturbed().kept.size()) << "two of one name";
  EXPECT_TRUE(all.contains("01_isotropic_end"));
  EXPECT_TRUE(all.contains("02_triaxial_end"));
  EXPECT_TRUE(all.contains("03_creep_end"));
  EXPECT_TRUE(all.contains("05_unload_end"));
  EXPECT_TRUE(all.contains("08_unload_end"));
  EXPECT_FALSE(all.contains("06_triaxial_end"));
  const double first = value(end_of(0), "axial_strain"), last = value(end_of(1), "axial_strain");
  int steps = 0;
  for (const auto& [name, bytes] : all) {
    const auto info = read_checkpoint_info(bytes);
    ASSERT_TRUE(info.ok()) << info.status();
    EXPECT_EQ(info->finished, name == "08_unload_end");
    double strain = 0.0;
    if (std::sscanf(name.c_str(), "02_triaxial_axial_strain_%lf", &strain) != 1) continue;
    ++steps;
    EXPECT_GT(strain, first);
    EXPECT_LE(strain, last);
    EXPECT_GE(info->axial_strain, strain);
    EXPECT_LT(info->axial_strain, strain + kKeptStrainStep);
  }
  EXPECT_EQ(steps,
            static_cast<int>(std::floor(last / kKeptStrainStep) - std::floor(first / kKeptStrainStep)));
  EXPECT_GE(steps, 1);
}

TEST(Program, a_kept_checkpoint_continues_its_own_run_to_the_same_end) {
  for (const auto& [name, bytes] : kept()) {
    auto run = creep::Run::resume(triaxial_job(), {}, bytes);
    if (read_checkpoint_info(bytes)->finished) {
      EXPECT_TRUE(absl::IsInvalidArgument(run.status())) << "nothing is left to do";
      continue;
    }
    ASSERT_TRUE(run.ok()) << name << ": " << run.status();
    Trace trace;
    const auto next = static_cast<std::ptrdiff_t>((*run)->next_sequence());
    trace.records.assign(undisturbed().records.begin(), undisturbed().records.begin() + next);
    finish(**run, trace);
    EXPECT_EQ(trace.digest, undisturbed().digest) << name;
    EXPECT_EQ(trace.records, undisturbed().records) << name;
  }
}

/// Creep at a deviatoric stress of its own, from a checkpoint of triaxial_job().
Experiment creep_from_checkpoint(double deviatoric_stress) {
  Experiment experiment = triaxial_job();
  experiment.start = Start{"the triaxial job", "02_triaxial_end"};
  experiment.program = {CreepStage{3600.0, {}, deviatoric_stress, {}}};
  return experiment;
}

Trace run_from(const Experiment& experiment, const std::string& checkpoint) {
  auto run = creep::Run::start_from(experiment, {}, checkpoint);
  EXPECT_TRUE(run.ok()) << run.status();
  Trace trace;
  if (run.ok()) finish(**run, trace);
  return trace;
}

TEST(Start, figures_before_creep_are_taken_where_the_hold_begins) {
  // From the middle of a loading stage, from between two stages, from the end of a hold of another job.
  const std::string in_mid_stage = kept().lower_bound("02_triaxial_axial_strain_")->first;
  ASSERT_TRUE(in_mid_stage.starts_with("02_triaxial_axial_strain_")) << in_mid_stage;
  for (const std::string& name :
       {in_mid_stage, std::string("02_triaxial_end"), std::string("03_creep_end")}) {
    Experiment experiment = creep_from_checkpoint(0.2e6);
    auto run = creep::Run::start_from(experiment, {}, kept().at(name));
    ASSERT_TRUE(run.ok()) << run.status();
    Trace trace;
    finish(**run, trace);
    const auto first = decode(trace.records.front());
    ASSERT_EQ(first->kind, RecordKind::kSample);
    std::map<std::string, double> figures;
    for (const SummaryFigure& figure : (*run)->summary()) figures[figure.name] = figure.value;
    EXPECT_EQ(figures.at("void_ratio_before_creep"), value(*first, "void_ratio")) << name;
    EXPECT_EQ(figures.at("broken_before_creep"), value(*first, "broken_total")) << name;
    EXPECT_EQ(figures.at("axial_stress_before_hold_Pa"), value(*first, "axial_stress_Pa")) << name;
  }
}

TEST(Start, one_sheared_specimen_serves_many_creep_tests) {
  const std::string& sheared = kept().at("02_triaxial_end");
  std::set<std::string> digests;
  for (const double stress : {0.2e6, 0.5e6}) {
    const Trace trace = run_from(creep_from_checkpoint(stress), sheared);
    ASSERT_EQ(trace.outcome, "completed");
    digests.insert(trace.digest);
    const auto first = decode(trace.records.front());
    EXPECT_EQ(first->sequence, 0U);
    // What the specimen went through stays: strains and breakages count on.
    EXPECT_EQ(value(*first, "axial_strain"), value(end_of(1), "axial_strain"));
    EXPECT_EQ(value(*first, "broken_total"), value(end_of(1), "broken_total"));
    const Record end = rows(trace, RecordKind::kStage, 0).back();
    EXPECT_NEAR(value(end, "axial_stress_end_Pa"), 1e6 + stress, 0.02 * (1e6 + stress));
  }
  EXPECT_EQ(digests.size(), 2U);
}

TEST(Start, holding_on_from_the_end_of_a_stage_is_the_same_as_going_on_in_one_program) {
  Experiment experiment = triaxial_job();
  experiment.start = Start{"the triaxial job", "02_triaxial_end"};
  experiment.program.erase(experiment.program.begin(), experiment.program.begin() + 2);
  EXPECT_EQ(run_from(experiment, kept().at("02_triaxial_end")).digest, undisturbed().digest);
}

TEST(Start, a_started_run_is_resumed_like_any_other) {
  const Experiment experiment = creep_from_checkpoint(0.4e6);
  const std::string& sheared = kept().at("02_triaxial_end");
  const Trace whole = run_from(experiment, sheared);
  auto run = creep::Run::start_from(experiment, {}, sheared);
  ASSERT_TRUE(run.ok());
  EXPECT_EQ((*run)->state_digest(), read_checkpoint_info(sheared)->state_digest);
  auto before_the_first_cycle = creep::Run::resume(experiment, {}, (*run)->checkpoint());
  ASSERT_TRUE(before_the_first_cycle.ok()) << before_the_first_cycle.status();
  Trace trace;
  for (const Record& record : (*before_the_first_cycle)->advance(100).records)
    trace.records.push_back(encode(record));
  const std::string checkpoint = (*before_the_first_cycle)->checkpoint();
  EXPECT_EQ(read_checkpoint_info(checkpoint)->start_digest, read_checkpoint_info(sheared)->state_digest);
  auto resumed = creep::Run::resume(experiment, {}, checkpoint);
  ASSERT_TRUE(resumed.ok()) << resumed.status();
  finish(**resumed, trace);
  EXPECT_EQ(trace.records, whole.records);
  EXPECT_EQ(trace.digest, whole.digest);
}

TEST(Start, another_specimen_is_refused) {
  const std::string& sheared = kept().at("02_triaxial_end");
  const std::vector<void (*)(Experiment&)> changes = {
      [](Experiment& e) { e.specimen.seed = 2; },
      [](Experiment& e) { e.specimen.void_ratio += 0.01; },
      [](Experiment& e) { e.material.density += 1.0; },
      [](Experiment& e) { e.material.limit_stress *= 1.01; },
      [](Experiment& e) { e.material.comminution_limit *= 1.01; },
  };
  for (std::size_t k = 0; k < changes.size(); ++k) {
    Experiment experiment = creep_from_checkpoint(0.4e6);
    changes[k](experiment);
    EXPECT_TRUE(absl::IsInvalidArgument(creep::Run::start_from(experiment, {}, sheared).status())) << k;
  }
  Experiment wetter = creep_from_checkpoint(0.4e6);
  wetter.material.crack_velocity *= 2.0;
  wetter.numerics.minimum_cycles = 300;
  EXPECT_TRUE(creep::Run::start_from(wetter, {}, sheared).ok());
  const std::string packing = started(triaxial_job())->checkpoint();
  EXPECT_TRUE(absl::IsInvalidArgument(creep::Run::start_from(wetter, {}, packing).status()))
      << "still packing";
  EXPECT_TRUE(absl::IsInvalidArgument(creep::Run::start(wetter, {}).status())) << "without its checkpoint";
}

/// Of a run that starts from the same specimen with the inertia scaled so.
struct Scaled {
  RunState end;
  std::map<std::string, double> summary;
};

Scaled with_inertia(InertiaScaling scaling) {
  Experiment experiment = triaxial_job();
  experiment.start = Start{"the triaxial job", "01_isotropic_end"};
  experiment.program = {OedometricStage{{3e6}}, CreepStage{3600.0, {}, {}, {}}};
  experiment.numerics.inertia_scaling = scaling;
  auto run = creep::Run::start_from(experiment, {}, kept().at("01_isotropic_end"));
  EXPECT_TRUE(run.ok()) << run.status();
  Trace trace;
  finish(**run, trace);
  EXPECT_EQ(trace.outcome, "completed");
  Scaled scaled{*read_checkpoint((*run)->checkpoint()), {}};
  for (const SummaryFigure& figure : (*run)->summary()) scaled.summary[figure.name] = figure.value;
  return scaled;
}

TEST(InertiaScaling, raises_what_is_lighter_than_its_reference_and_nothing_else) {
  const LognormalGrading sand;
  const double finest = sphere_mass(0.5 * sand.min_diameter, Material{}.density);
  const double median = sphere_mass(0.5 * median_diameter(sand), Material{}.density);
  for (const InertiaScaling scaling :
       {InertiaScaling::kNone, InertiaScaling::kFragments, InertiaScaling::kAll}) {
    const Particles particles = with_inertia(scaling).end.specimen.particles;
    std::int64_t raised_grains = 0, raised_fragments = 0;
    for (std::size_t i = 0; i < particles.size(); ++i) {
      const bool grain = particles.generation[i] == 0;
      double reference = 0.0;
      if (scaling == InertiaScaling::kAll) reference = median;
      if (scaling == InertiaScaling::kFragments && !grain) reference = finest;
      EXPECT_EQ(particles.inertial_mass[i], std::max(particles.mass[i], reference));
      if (particles.inertial_mass[i] > particles.mass[i]) ++(grain ? raised_grains : raised_fragments);
    }
    EXPECT_EQ(raised_grains > 0, scaling == InertiaScaling::kAll);
    EXPECT_EQ(raised_fragments > 0, scaling != InertiaScaling::kNone);
  }
}

TEST(InertiaScaling, suspends_the_clock_of_dynamic_stages_and_closes_the_ledger) {
  const double before = read_checkpoint(kept().at("01_isotropic_end"))->specimen.clocks.dynamic_time;
  std::map<InertiaScaling, Scaled> runs;
  for (const InertiaScaling scaling :
       {InertiaScaling::kNone, InertiaScaling::kFragments, InertiaScaling::kAll}) {
    runs[scaling] = with_inertia(scaling);
    auto& summary = runs[scaling].summary;
    const bool scaled = scaling != InertiaScaling::kNone;
    EXPECT_EQ(summary["dynamic_time_s"] == before, scaled);
    EXPECT_EQ(summary["suspended_time_s"] > 0.0, scaled);
    EXPECT_GT(summary["broken_total"], 0.0);
    // 0.1 % of the input: the bound on the ledger of every run
    EXPECT_LT(std::fabs(summary["energy_unexplained_J"]), 1e-3 * summary["wall_work_J"]);
  }
  // Fragments of 0.230093 of the radius of grains of 0.1 mm and more are raised at least to 0.1 mm: the step
  // goes with the root of the mass, and the end states differ.
  EXPECT_GT(runs[InertiaScaling::kFragments].end.specimen.time_step,
            1.5 * runs[InertiaScaling::kNone].end.specimen.time_step);
  EXPECT_GT(runs[InertiaScaling::kAll].end.specimen.time_step,
            1.2 * runs[InertiaScaling::kFragments].end.specimen.time_step);
}

/// Killed after every so many cycles.
std::string digest_of_a_run_in_pieces(const Experiment& experiment, std::int64_t piece) {
  std::unique_ptr<creep::Run> run = started(experiment);
  for (;;) {
    const Batch batch = run->advance(piece);
    if (batch.outcome) return run->state_digest();
    auto resumed = creep::Run::resume(experiment, {}, run->checkpoint());
    EXPECT_TRUE(resumed.ok()) << resumed.status();
    run = *std::move(resumed);
  }
}

Experiment adaptive_job() {
  Experiment experiment = testing::short_job();
  experiment.numerics.breakages_per_ageing.reset();
  experiment.numerics.ageing_error_tolerance = 0.2;
  experiment.numerics.drift_tolerance = 0.5;
  return experiment;
}

TEST(Methods, that_watch_failure_times_survive_kills_bit_for_bit) {
  const Trace whole = whole_run(adaptive_job());
  ASSERT_EQ(whole.outcome, "completed");
  EXPECT_EQ(digest_of_a_run_in_pieces(adaptive_job(), 777), whole.digest);
}

TEST(Methods, a_stage_that_waits_for_its_failure_times_is_longer_the_closer_they_must_stand) {
  double before = 0.0;
  for (const double tolerance : {1e9, 1e-3}) {
    Experiment experiment = testing::short_job();
    experiment.numerics.drift_tolerance = tolerance;
    const Trace trace = whole_run(experiment);
    ASSERT_EQ(trace.outcome, "completed");
    const double cycles = value(rows(trace, RecordKind::kStage, 1).front(), "cycles");
    EXPECT_GE(cycles, 2.0 * 400) << "two looks, a window apart";
    EXPECT_GT(cycles, before);
    before = cycles;
  }
}

TEST(Methods, platens_slow_down_at_the_inertial_number_asked_for) {
  Experiment experiment = testing::short_job();
  experiment.program = {OedometricStage{{3e6}}};
  double fastest = 0.0;
  for (const std::optional<double> limit : {std::optional<double>(), std::optional<double>(2e-3)}) {
    experiment.numerics.inertial_number_limit = limit;
    const Trace trace = whole_run(experiment);
    ASSERT_EQ(trace.outcome, "completed");
    double largest = 0.0;
    for (const Record& sample : rows(trace, RecordKind::kSample, 0)) {
      if (value(sample, "phase") == static_cast<double>(Phase::kLoading))
        largest = std::max(largest, value(sample, "inertial_number"));
    }
    if (!limit) fastest = largest;
    // The cap is that of the stress a cycle before, and stress falls by far less than half in a cycle.
    if (limit) {
      EXPECT_LT(largest, 1.5 * *limit);
    }
  }
  EXPECT_GT(fastest, 3e-3) << "or the limit had nothing to do";
}

std::string ends_with(const Experiment& experiment) { return whole_run(experiment).outcome; }

TEST(Guard, names_a_step_beyond_its_bound) {
  Experiment experiment = triaxial_job();
  experiment.start = Start{"the triaxial job", "01_isotropic_end"};
  experiment.program = {OedometricStage{{3e6}}};
  for (const double safety : {5.0, 50.0}) {
    experiment.numerics.time_step_safety = safety;
    const std::string outcome = run_from(experiment, kept().at("01_isotropic_end")).outcome;
    EXPECT_TRUE(outcome.starts_with("guard ")) << safety << ": " << outcome;
  }
}

TEST(Guard, names_a_servo_that_ran_away) {
  // A hold that was on target, of a stress a twentieth of the one that its walls bear now.
  const std::unique_ptr<creep::Run> run = started(testing::short_job());
  while (run->progress().phase != Phase::kDynamicStage) run->advance(100);
  run->advance(50);
  RunState state = *read_checkpoint(run->checkpoint());
  const CheckpointInfo info = *read_checkpoint_info(run->checkpoint());
  for (const bool was_on_target : {false, true}) {
    state.aim.axial = state.specimen.walls.stress(2) / 20.0;
    std::optional<std::int64_t>& on_target = std::get<DynamicStage>(state.act).calm.on_target;
    on_target.reset();
    if (was_on_target) on_target = 0;
    auto resumed = creep::Run::resume(testing::short_job(), {}, write_checkpoint(state, info));
    ASSERT_TRUE(resumed.ok()) << resumed.status();
    const Batch batch = (*resumed)->advance(1);
    ASSERT_EQ(batch.outcome.has_value(), was_on_target);
    if (was_on_target) {
      EXPECT_TRUE(batch.outcome->reason.starts_with("guard servo: ")) << batch.outcome->reason;
      EXPECT_NE(batch.outcome->advice, "");
    }
  }
}

TEST(Guard, names_a_hold_whose_walls_and_contacts_tell_different_stresses) {
  // Grains of 2 cm bear more than is summed of one contact at a wall: the walls tell 1.2 MPa, the contacts
  // more.
  Experiment experiment = testing::short_job();
  experiment.specimen.particles = 60;
  experiment.specimen.void_ratio = 0.9;
  experiment.specimen.grading = GradingPoints{{{15e-3, 0.0}, {20e-3, 0.5}, {25e-3, 1.0}}};
  experiment.material.roughness = 60e-6;
  experiment.material.comminution_limit = 1.0;
  experiment.program = {OedometricStage{{1.2e6}}, CreepStage{3600.0, {}}};
  const std::string outcome = whole_run(experiment).outcome;
  EXPECT_TRUE(outcome.starts_with("guard stress: dynamic stage 0 ends with 1.2")) << outcome;
}

TEST(Guard, names_energy_that_comes_from_nowhere) {
  // A ledger by which a tenth more came out than the walls put in.
  const std::unique_ptr<creep::Run> run = started(testing::short_job());
  while (run->progress().phase != Phase::kDynamicStage) run->advance(100);
  RunState state = *read_checkpoint(run->checkpoint());
  const CheckpointInfo info = *read_checkpoint_info(run->checkpoint());
  state.specimen.energy.removed_kinetic += 0.1 * state.specimen.energy.wall_work;
  auto resumed = creep::Run::resume(testing::short_job(), {}, write_checkpoint(state, info));
  ASSERT_TRUE(resumed.ok()) << resumed.status();
  Batch batch;
  do {
    batch = (*resumed)->advance(1000000);
  } while (!batch.outcome);
  EXPECT_TRUE(batch.outcome->reason.starts_with("guard energy: ")) << batch.outcome->reason;
}

TEST(Guard, names_a_loading_too_fast_to_be_borne) {
  Experiment experiment = testing::short_job();
  experiment.numerics.loading_velocity = 200.0;
  EXPECT_TRUE(ends_with(experiment).starts_with("guard inertia: ")) << ends_with(experiment);
}

TEST(Guard, names_a_stage_that_never_settles) {
  Experiment experiment = testing::short_job();
  experiment.numerics.unbalanced_tolerance = 1e-30;
  EXPECT_TRUE(ends_with(experiment).starts_with("guard settling: ")) << ends_with(experiment);
}

TEST(Program, a_specimen_that_flows_under_its_load_has_failed_in_creep) {
  Experiment experiment = triaxial_job();
  experiment.start = Start{"the triaxial job", ""};
  experiment.program = {CreepStage{3600.0, {}, 8e6, {}}};
  experiment.material.crack_velocity = 0.0;
  const Trace trace = run_from(experiment, kept().at("02_triaxial_end"));
  EXPECT_TRUE(trace.outcome.starts_with("creep failure")) << trace.outcome;
}

TEST(Program, without_crushing_nothing_breaks_and_the_age_passes_in_one_jump) {
  Experiment experiment = triaxial_job();
  experiment.material.comminution_limit = std::numeric_limits<double>::infinity();
  experiment.program = {IsotropicStage{{3e6, Target::Measure::kMeanStress}, {}},
                        CreepStage{86400.0, {}, {}, {}}};
  const Trace trace = whole_run(experiment);
  EXPECT_EQ(trace.outcome, "completed");
  const std::vector<Record> stages = rows(trace, RecordKind::kStage, 1);
  EXPECT_EQ(stages.size(), 2U) << "the initial stage and the closing one";
  EXPECT_EQ(value(rows(trace, RecordKind::kSample, 1).back(), "broken_total"), 0.0);
}

TEST(Record, samples_of_earlier_versions_are_completed_with_mean_and_deviatoric_stress) {
  Record record{RecordKind::kSample, 5, std::vector<double>(columns(RecordKind::kSample).size(), 1.0)};
  record.values[column_index(RecordKind::kSample, "axial_stress_Pa")] = 4e6;
  record.values[column_index(RecordKind::kSample, "radial_stress_Pa")] = 1e6;
  record.values.resize(record.values.size() - 2);
  const auto read = decode(encode(record));
  ASSERT_TRUE(read.ok()) << read.status();
  EXPECT_EQ(value(*read, "mean_stress_Pa"), 2e6);
  EXPECT_EQ(value(*read, "deviatoric_stress_Pa"), 3e6);
  record.values.pop_back();
  EXPECT_FALSE(decode(encode(record)).ok());
}

}  // namespace
}  // namespace creep
