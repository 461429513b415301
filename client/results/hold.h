// The creep stage of a job as the plots and the report see it, and the paper's figures it may be compared
// with.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "client/results/job_results.h"
#include "core/analysis/creep_analysis.h"

namespace creepctl {

/// A hold of a job.
struct Hold {
  double program_stage = 0.0;            ///< its place in the program
  std::vector<std::size_t> stage_rows;   ///< its dynamic stages in stages.csv
  std::vector<std::size_t> sample_rows;  ///< its rows of samples.csv
  double strain_before = 0.0;            ///< axial strain when it began [-]
  creep::CreepCurve curve;               ///< at the ends of the dynamic stages, strain since it began
  creep::CreepAnalysis analysis;
  std::optional<creep::LogTimeFit> grading_index_fit;  ///< I_G on log creep time; `strain_` stands for I_G

  /// Dynamic stages that an ageing jump opened; the initial one is not among them.
  std::size_t ageing_jumps() const { return stage_rows.empty() ? 0 : stage_rows.size() - 1; }
};

/// The last creep stage; nullopt until its first dynamic stage has begun.
std::optional<Hold> last_hold(const JobResults& results);

/// The last relaxation stage, alike.
std::optional<Hold> last_relaxation(const JobResults& results);

/// Rows of samples.csv from the end of packing on, the state where strains are zero. Empty before loading
/// began.
std::vector<std::size_t> loading_and_creep_samples(const JobResults& results);

// Lei, Arroyo, Ciantia & Zhang, section 4.2 and figures 7 and 8: the oedometric creep test.
inline constexpr double kPaperAxialStress = 21.7e6;      ///< [Pa]
inline constexpr double kPaperInitialVoidRatio = 0.65;   ///< [-]
inline constexpr double kPaperVoidRatio = 0.584;         ///< before creep [-]
inline constexpr double kPaperDynamicStages = 15.0;      ///< during creep
inline constexpr double kPaperRipple = 0.04;             ///< of the axial stress, not reached [-]
inline constexpr double kPaperDuration = 2.0 * 86400.0;  ///< [s]

/// Which of the paper's figures this job's scene is a trial of.
struct PaperScene {
  bool compression = false;  ///< Fontainebleau NE34 from e = 0.65 to 21.7 MPa, oedometric
  bool creep = false;        ///< and held there for two days
};

PaperScene paper_scene(const JobResults& results);

/// "2 d", "3.4 h", "12.5 min", "0.9 ms" for seconds.
std::string duration_text(double seconds);

}  // namespace creepctl
