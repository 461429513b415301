#include "tests/core/run_scene.h"

#include <gtest/gtest.h>

#include "core/arithmetic/check.h"
#include "tests/core/dem_scenes.h"

namespace creep::testing {

Experiment short_job() {
  Experiment experiment = weak_sand(80);
  experiment.program = {OedometricStage{3e6}, CreepStage{86400.0, {}}};
  experiment.numerics.minimum_cycles = 400;
  experiment.numerics.breakages_per_ageing = 1;
  experiment.numerics.loading_velocity = 2.0;
  experiment.numerics.settle_tolerance = 0.02;
  experiment.numerics.unbalanced_tolerance = 1e-2;
  return experiment;
}

Experiment triaxial_job() {
  using Measure = Target::Measure;
  Experiment experiment = short_job();
  experiment.program = {
      IsotropicStage{{1e6, Measure::kMeanStress}, Keep{}},
      TriaxialStage{
          {0.5e6, Measure::kDeviatoricStress}, {}, 2.0, Keep{kKeptStrainStep, Measure::kAxialStrain}},
      CreepStage{3600.0, {}, {}, Keep{}},
      RelaxationStage{3600.0, {}},
      UnloadStage{{0.1e6, Measure::kDeviatoricStress}, Keep{0.1e6, Measure::kDeviatoricStress}},
      TriaxialStage{{0.15, Measure::kAxialStrain}, {}, 2.0, {}},
      CreepStage{60.0, {}, 0.3e6, {}},
      UnloadStage{{0.5e6, Measure::kMeanStress}, Keep{}},
  };
  return experiment;
}

std::unique_ptr<Run> started(const Experiment& experiment, const RunOptions& options) {
  auto run = Run::start(experiment, options);
  CREEP_CHECK(run.ok(), "a run of the tests does not start");
  return *std::move(run);
}

void finish(Run& run, Trace& trace, std::int64_t budget) {
  for (;;) {
    const Batch batch = run.advance(budget);
    for (const Record& record : batch.records) {
      EXPECT_EQ(record.sequence, trace.records.size()) << "a gap or a repeat";
      trace.records.push_back(encode(record));
    }
    trace.kept.insert(trace.kept.end(), batch.kept.begin(), batch.kept.end());
    if (!batch.outcome) continue;
    trace.outcome = batch.outcome->reason;
    trace.digest = run.state_digest();
    return;
  }
}

Trace whole_run(const Experiment& experiment, const RunOptions& options, std::int64_t budget) {
  const std::unique_ptr<Run> run = started(experiment, options);
  Trace trace;
  finish(*run, trace, budget);
  return trace;
}

}  // namespace creep::testing
