// A pilot: a small specimen of a job, computed by the same worker, to see what the job will need. Pure; who
// runs it is somebody else.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "core/experiment/experiment.h"

namespace creep {

/// What one stage of the program took.
struct PilotStage {
  double loading_cycles = 0.0;
  double time_step = 0.0;       ///< mean while loading, else at the end of its last dynamic stage [s]
  double shortening = 0.0;      ///< axial strain while loading, either way [-]
  double dynamic_stages = 0.0;  ///< of a hold
  double dynamic_cycles = 0.0;  ///< mean of one
  double growth = 1.0;          ///< particles at its end over the initial ones [-]
};

struct Pilot {
  double particles = 0.0;         ///< at the start
  double loading_velocity = 0.0;  ///< largest closing speed [m/s]
  double axial_velocity = 0.0;    ///< of triaxial stages [m/s]
  double breakages = 1.0;         ///< n_age
  double packing_cycles = 0.0;
  double packing_speed = 0.0;      ///< particle-steps per second of wall time, while packing
  double speed = 0.0;              ///< the same, after packing
  double seconds = 0.0;            ///< of wall time, all in all
  std::string reason;              ///< how it ended
  std::vector<PilotStage> stages;  ///< of the program, as far as it came
};

inline constexpr double kPilotParticles = 1500;  ///< at most; fewer are packed more loosely

/// Particles at the start.
double particle_count(const SpecimenSpec& specimen);

/// The job file of the pilot: at most kPilotParticles particles, loaded faster, with dynamic stages no longer
/// than they need to settle. `job` is what `text` says. Error: InvalidArgument (the job starts from a
/// checkpoint).
absl::StatusOr<std::string> pilot_text(std::string_view text, const Experiment& job);

/// What a finished pilot left.
struct PilotTables {
  std::string job;      ///< its job.toml
  std::string stages;   ///< stages.csv
  std::string timings;  ///< stage_timings.csv
  std::string reason;   ///< how it ended
};

/// Error: InvalidArgument, for a table that cannot be read.
absl::StatusOr<Pilot> read_pilot(const PilotTables& tables);

}  // namespace creep
