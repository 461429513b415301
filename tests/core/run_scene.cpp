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
