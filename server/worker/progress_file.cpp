#include "server/worker/progress_file.h"

#include <algorithm>
#include <cmath>

#include <nlohmann/json.hpp>

#include "core/folder/durable_file.h"

namespace creepd {
namespace {

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

}  // namespace

void ProgressFile::saw(const creep::Record& record) {
  if (record.kind == creep::RecordKind::kSample) sample_ = record;
}

void ProgressFile::worked(double particle_steps, double wall_seconds) {
  if (wall_seconds <= 0.0) return;
  constexpr double kMemory = 10.0;  // [s]
  const double weight = recent_speed_ > 0.0 ? 1.0 - std::exp(-wall_seconds / kMemory) : 1.0;
  recent_speed_ += weight * (particle_steps / wall_seconds - recent_speed_);
}

bool ProgressFile::due() const { return written_ == Clock::time_point{} || seconds_since(written_) >= 1.0; }

absl::Status ProgressFile::offer(const State& state) {
  return due() ? creep::replace_file(path_, text_of(state)) : absl::OkStatus();
}

absl::Status ProgressFile::write(const State& state) { return creep::write_durably(path_, text_of(state)); }

std::string ProgressFile::text_of(const State& state) {
  const auto figure = [&](const char* column) -> nlohmann::ordered_json {
    if (!sample_) return nullptr;
    return sample_->values[creep::column_index(creep::RecordKind::kSample, column)];
  };
  const auto left = seconds_left(state.progress);
  const double average =
      state.total.wall_seconds > 0.0 ? state.total.particle_steps / state.total.wall_seconds : 0.0;
  const nlohmann::ordered_json json = {
      {"state", state.state},
      {"attempt", attempt_},
      {"stage", state.progress.stage},
      {"stage_index", state.progress.stage_index},
      {"stage_count", state.progress.stage_count},
      {"phase", std::string(creep::phase_name(state.progress.phase))},
      {"stage_fraction", state.progress.stage_fraction},
      {"dynamic_stage", state.progress.dynamic_stage},
      {"creep_time_s", figure("creep_time_s")},
      {"axial_strain", figure("axial_strain")},
      {"axial_stress_Pa", figure("axial_stress_Pa")},
      {"void_ratio", figure("void_ratio")},
      {"grading_index", figure("grading_index")},
      {"broken_total", figure("broken_total")},
      {"particles", state.progress.particles},
      {"particle_steps_per_second", {{"recent", recent_speed_}, {"average", average}}},
      {"wall_seconds", state.total.wall_seconds},
      {"seconds_left", left ? nlohmann::ordered_json(*left) : nlohmann::ordered_json(nullptr)},
      {"warnings", state.warnings}};
  written_ = Clock::now();
  return json.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + "\n";
}

std::optional<double> ProgressFile::seconds_left(const creep::Progress& progress) {
  if (!entry_ || entry_->stage_index != progress.stage_index) {
    entry_ = Entry{progress.stage_index, progress.stage_fraction, Clock::now()};
  }
  const double gained = progress.stage_fraction - entry_->stage_fraction;
  const double spent = seconds_since(entry_->since);
  // Below these the guess would swing by factors.
  if (progress.stage_index + 1 != progress.stage_count || gained < 0.02 || spent < 3.0) return std::nullopt;
  return std::max(0.0, (1.0 - progress.stage_fraction) * spent / gained);
}

}  // namespace creepd
