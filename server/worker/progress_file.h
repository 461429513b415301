// progress.json: where the run is now, for whoever watches. Replaced at most once a second; never needed to
// go on.
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "core/output/record.h"
#include "core/run/run.h"
#include "server/worker/stage_timings.h"

namespace creepd {

class ProgressFile {
 public:
  ProgressFile(std::filesystem::path path, std::int64_t attempt)
      : path_(std::move(path)), attempt_(attempt) {}

  /// Remembers the figures of the latest sample.
  void saw(const creep::Record& record);

  /// Counts work just done [wall seconds].
  void worked(double particle_steps, double wall_seconds);

  struct State {
    creep::Progress progress;
    Cost total;  ///< of all attempts
    std::vector<std::string> warnings;
    std::string state;  ///< "running", or the outcome at the end
  };

  /// Replaces the file unless that was done within the last second.
  absl::Status offer(const State& state);
  /// Replaces the file, durably: the last word of an attempt.
  absl::Status write(const State& state);

  /// True if offer() would write: lets the caller skip collecting the state.
  bool due() const;

 private:
  std::string text_of(const State& state);
  /// Seconds left in the last stage of the program, at the speed since this attempt entered it; nothing
  /// earlier, because what the later stages will cost is not known.
  std::optional<double> seconds_left(const creep::Progress& progress);

  std::filesystem::path path_;
  std::int64_t attempt_;
  std::optional<creep::Record> sample_;
  std::chrono::steady_clock::time_point written_{};
  double recent_speed_ = 0.0;  ///< particle-steps per second, smoothed over about ten seconds
  struct Entry {
    std::int64_t stage_index;
    double stage_fraction;
    std::chrono::steady_clock::time_point since;
  };
  std::optional<Entry> entry_;  ///< into the stage being computed
};

}  // namespace creepd
