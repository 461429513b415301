// A pilot: a small specimen of a job, computed here and now by the same worker, to see what the job will
// need.
#pragma once

#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "client/job_file.h"

namespace creepctl {

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
double particle_count(const creep::SpecimenSpec& specimen);

/// The job on at most kPilotParticles particles, loaded faster and with dynamic stages no longer than they
/// need to settle. Its folder is a temporary one that is removed. Errors: InvalidArgument (the job starts
/// from a checkpoint), Unavailable (no worker, no folder), Aborted (stopped by a guard or a signal).
absl::StatusOr<Pilot> run_pilot(const JobFile& job, int threads);

}  // namespace creepctl
