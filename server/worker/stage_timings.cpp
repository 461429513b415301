#include "server/worker/stage_timings.h"

#include <cstdio>
#include <sstream>
#include <string>

#include "core/folder/durable_file.h"

namespace creepd {

absl::StatusOr<StageTimings> StageTimings::open(const std::filesystem::path& path) {
  StageTimings timings(path);
  const auto text = creep::read_file(path);
  if (absl::IsNotFound(text.status())) return timings;
  if (!text.ok()) return text.status();
  std::istringstream lines(*text);
  for (std::string line; std::getline(lines, line);) {
    long long row = 0;
    long long rebuilds = 0;
    Cost cost;
    if (std::sscanf(line.c_str(), "%lld,%lld,%lf,%lf", &row, &rebuilds, &cost.wall_seconds,
                    &cost.particle_steps) != 4) {
      continue;
    }
    cost.rebuilds = rebuilds;
    timings.add(row, cost);
  }
  return timings;
}

void StageTimings::add(std::int64_t row, const Cost& cost) {
  Cost& sum = rows_[row];
  sum.rebuilds += cost.rebuilds;
  sum.wall_seconds += cost.wall_seconds;
  sum.particle_steps += cost.particle_steps;
}

Cost StageTimings::of(std::int64_t row) const {
  const auto found = rows_.find(row);
  return found == rows_.end() ? Cost{} : found->second;
}

Cost StageTimings::total() const {
  Cost sum;
  for (const auto& [row, cost] : rows_) {
    sum.rebuilds += cost.rebuilds;
    sum.wall_seconds += cost.wall_seconds;
    sum.particle_steps += cost.particle_steps;
  }
  return sum;
}

absl::Status StageTimings::write() const {
  std::string text = "stage_row,rebuilds,wall_seconds,particle_steps\n";
  for (const auto& [row, cost] : rows_) {
    char line[160];
    std::snprintf(line, sizeof line, "%lld,%lld,%.6f,%.0f\n", static_cast<long long>(row),
                  static_cast<long long>(cost.rebuilds), cost.wall_seconds, cost.particle_steps);
    text += line;
  }
  return creep::write_durably(path_, text);
}

}  // namespace creepd
