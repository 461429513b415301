// stage_timings.csv: what the stages cost, summed over attempts. Depends on the machine and on kills, so it
// is kept apart from the records, which do not.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>

#include "absl/status/status.h"
#include "absl/status/statusor.h"

namespace creepd {

struct Cost {
  std::int64_t rebuilds = 0;    ///< neighbour searches
  double wall_seconds = 0.0;    ///< [s] of computing, repeated work after a kill included
  double particle_steps = 0.0;  ///< cycles x particles
};

class StageTimings {
 public:
  /// What packing cost; rows of stages.csv count from 0.
  static constexpr std::int64_t kPacking = -1;

  /// Reads what earlier attempts left. Lines that make no sense are passed over: cost is not worth a failed
  /// job.
  static absl::StatusOr<StageTimings> open(const std::filesystem::path& path);

  /// Adds to row `row` of stages.csv, or to kPacking.
  void add(std::int64_t row, const Cost& cost);

  Cost of(std::int64_t row) const;
  Cost total() const;

  /// Replaces the file, durably.
  absl::Status write() const;

 private:
  explicit StageTimings(std::filesystem::path path) : path_(std::move(path)) {}

  std::filesystem::path path_;
  std::map<std::int64_t, Cost> rows_;
};

}  // namespace creepd
