// A whole job in a third of a second: packing, crushing to 3 MPa, a hold with ageing jumps.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "core/experiment/experiment.h"
#include "core/run/run.h"

namespace creep::testing {

/// Weak grains, loaded fast, with short dynamic stages: nothing physical, but every mechanism takes part.
Experiment short_job();

/// The same grains through every other stage: isotropic, triaxial, creep at a deviatoric stress, relaxation,
/// unloading, reloading; with checkpoints kept on the way.
Experiment triaxial_job();
inline constexpr double kKeptStrainStep = 0.0005;

/// A run that must start.
std::unique_ptr<Run> started(const Experiment& experiment, const RunOptions& options = {});

/// What a run leaves behind.
struct Trace {
  std::vector<std::string> records;  ///< encoded, in sequence
  std::string digest;
  std::string outcome;
  std::vector<KeptCheckpoint> kept;
};

/// Advances to the end, `budget` cycles at a time, appending to what `trace` has.
void finish(Run& run, Trace& trace, std::int64_t budget = 1000000);

Trace whole_run(const Experiment& experiment, const RunOptions& options = {}, std::int64_t budget = 1000000);

}  // namespace creep::testing
