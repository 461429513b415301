// What a job will need, from what a pilot of it took. Pure.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/experiment/experiment.h"
#include "core/plan/pilot.h"

namespace creep {

/// A prediction and where it is believed to lie.
struct Range {
  double expected = 0.0;
  double least = 0.0;
  double most = 0.0;
};

struct PlannedStage {
  std::string text;        ///< "oedometric to 21.7 MPa"
  Range dynamic_stages;    ///< of a hold, its first one included
  double cycles = 0.0;     ///< all in all
  double time_step = 0.0;  ///< [s]
  double particle_steps = 0.0;
};

struct Plan {
  double particles = 0.0;
  double packing_particle_steps = 0.0;
  std::vector<PlannedStage> stages;
  Range wall_seconds;           ///< here, now [s]
  double memory = 0.0;          ///< of the worker [bytes]
  std::optional<double> error;  ///< measured of the fidelity [-]; none if keys of it are overridden
};

/// The number of jumps of one specimen scatters by a third from one seed to the next (standard deviation over
/// mean, tests/studies/accuracy_speed): a pilot is one seed, the job another.
inline constexpr double kStageFactor = 1.5;
/// Stages, and a speed that was measured for seconds on a machine that may be busier later.
inline constexpr double kSecondsFactor = 2.0;

/// Extrapolates: as many dynamic stages as n_age and the particles ask for, each at least minimum_cycles
/// long; loading over the edge of the specimen at the velocity of the job; the same time step and speed. A
/// stage that the pilot did not reach is left out.
Plan make_plan(const Experiment& job, const Pilot& pilot);

}  // namespace creep
