// What a run shows while it goes on: progress.json as one line of text. Pure functions.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/experiment/experiment.h"

namespace creepctl {

/// progress.json as far as it is shown. Figures are missing before the first sample.
struct RunProgress {
  std::string stage;
  std::string phase;
  std::int64_t stage_index = -1;
  std::int64_t dynamic_stage = 0;
  double stage_fraction = 0.0;
  double particle_steps_per_second = 0.0;
  std::optional<double> creep_time;    ///< [s]
  std::optional<double> axial_strain;  ///< [-]
  std::optional<double> axial_stress;  ///< [Pa]
  std::optional<double> void_ratio;
  std::optional<double> grading_index;
  std::optional<double> broken_total;
  std::optional<double> seconds_left;
  std::vector<std::string> warnings;
};

/// Nothing if the text is no progress.json.
std::optional<RunProgress> parse_run_progress(std::string_view json);

/// "creep 3  12 min ▕████░░▏ 2 d  strain 0.52 %  I_G 0.123  ..." in at most `width` columns; what does not
/// fit is left out, the least important first. The bar of a creep stage is logarithmic in creep_time.
std::string live_line(const RunProgress& progress, const creep::Experiment& experiment, int width,
                      bool unicode);

/// "creep, dynamic stage 3, creep time 12 min of 2 d, strain 0.52 %, ...": everything, plain ASCII.
std::string plain_line(const RunProgress& progress, const creep::Experiment& experiment);

/// Two or three digits and the unit that reads best: "0.0012 s", "35 s", "12 min", "3.4 h", "1.2 d".
std::string short_duration(double seconds);

}  // namespace creepctl
