// The progress of one job on one stream: a line that is drawn over on a terminal, whole lines elsewhere.
#pragma once

#include <chrono>
#include <cstdint>
#include <cstdio>
#include <string>

#include "client/terminal/run_progress.h"
#include "core/experiment/experiment.h"

namespace creepctl {

class ProgressDisplay {
 public:
  /// `experiment` must outlive the display.
  ProgressDisplay(std::FILE* stream, const creep::Experiment& experiment);

  /// Elsewhere than on a terminal: a line at each stage and dynamic stage, else one in five seconds.
  void show(const RunProgress& progress, bool at_the_end);

  /// A line that stays, on the display's stream or on stderr.
  void say(const std::string& line);
  void warn(const std::string& line);

  /// Ends the live line where it is, so that what follows begins on a line of its own.
  void finish();

 private:
  using Clock = std::chrono::steady_clock;

  void clear();

  std::FILE* stream_;
  const creep::Experiment& experiment_;
  bool live_;
  bool unicode_;
  bool line_open_ = false;  // a live line without its newline
  Clock::time_point start_ = Clock::now();
  Clock::time_point shown_{};
  std::int64_t shown_stage_ = -2;  // none
  std::int64_t shown_dynamic_stage_ = -1;
  std::size_t warnings_shown_ = 0;
};

}  // namespace creepctl
