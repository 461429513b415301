#include "tests/client/synthetic_job.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <random>
#include <utility>
#include <vector>

#include "core/output/record.h"

namespace creepctl {
namespace {

using creep::RecordKind;

constexpr double kInitialStageEnd = 1.1e-3;  // creep_time [s]
constexpr double kStrainBefore = 0.041;      // at the end of loading
constexpr double kDynamicDuration = 0.9e-3;  // of a dynamic stage [s]
constexpr double kVoidRatioAtStart = 0.6497;

class Writer {
 public:
  explicit Writer(const std::filesystem::path& directory) {
    for (const RecordKind kind : creep::kRecordKinds) text(kind) = creep::csv_header(kind);
    text(RecordKind::kStage) += ",rebuilds,wall_seconds";
    for (const RecordKind kind : creep::kRecordKinds) text(kind) += "\n";
    directory_ = directory;
  }

  using Values = std::vector<std::pair<std::string, double>>;
  void add(RecordKind kind, const Values& values) {
    creep::Record record{kind, sequence_++, std::vector<double>(creep::columns(kind).size(), 0.0)};
    for (const auto& [name, value] : values) record.values[creep::column_index(kind, name)] = value;
    text(kind) += creep::csv_row(record) + (kind == RecordKind::kStage ? ",41,12.5\n" : "\n");
  }

  void save() {
    const char* const names[] = {"samples.csv", "stages.csv", "breakages.csv", "gsd.csv"};
    for (std::size_t i = 0; i < 4; ++i) std::ofstream(directory_ / names[i]) << texts_[i];
  }

 private:
  std::string& text(RecordKind kind) { return texts_[static_cast<std::size_t>(kind) - 1]; }

  std::filesystem::path directory_;
  std::uint64_t sequence_ = 0;
  std::string texts_[4];
};

struct State {
  double creep_time = 0.0;
  double strain = 0.0;
  double stress = 21.7e6;
  double broken = 0.0;
};

double void_ratio(const State& state) { return (1.0 + kVoidRatioAtStart) * (1.0 - state.strain) - 1.0; }
double grading_index(const State& state) { return 0.21 + 3e-4 * state.broken; }

void add_sample(Writer& writer, double stage, double phase, double dynamic_stage, const State& state) {
  const double work = 1e-4 * state.strain;
  writer.add(RecordKind::kSample, {{"stage", stage},
                                   {"phase", phase},
                                   {"dynamic_stage", dynamic_stage},
                                   {"creep_time_s", state.creep_time},
                                   {"axial_strain", state.strain},
                                   {"axial_stress_Pa", state.stress},
                                   {"void_ratio", void_ratio(state)},
                                   {"void_ratio_particles", void_ratio(state) + 1e-4 * state.broken},
                                   {"grading_index", grading_index(state)},
                                   {"broken_total", state.broken},
                                   {"particles", 3000.0 + 13.0 * state.broken},
                                   {"wall_work_J", work},
                                   {"normal_elastic_J", 0.4 * work},
                                   {"friction_J", 0.5 * work},
                                   {"damping_J", 0.0999 * work},
                                   {"energy_unexplained_J", 1e-4 * work},
                                   {"mass_unexplained", 3e-15}});
}

void add_grading(Writer& writer, double curve, const State& state) {
  for (int i = 0; i <= 60; ++i) {
    const double diameter = 0.02e-3 * std::pow(20.0, i / 60.0);
    const double lognormal = 0.5 * std::erfc(-std::log(diameter / 0.21e-3) / 0.277 / std::sqrt(2.0));
    const double fines = 2e-4 * state.broken * std::pow(diameter / 0.4e-3, 0.4);
    const double passing = i == 60 ? 1.0 : std::min(1.0, lognormal + fines * (1.0 - lognormal));
    writer.add(RecordKind::kGrading, {{"curve", curve},
                                      {"creep_time_s", state.creep_time},
                                      {"diameter_m", diameter},
                                      {"passing", diameter < 0.1e-3 && curve == 0.0 ? 0.0 : passing}});
  }
}

void add_breakages(Writer& writer, double cause, double dynamic_stage, State& state, int count) {
  for (int i = 0; i < count; ++i) {
    state.broken += 1.0;
    const double place = std::fmod(0.618034 * state.broken, 1.0);
    writer.add(RecordKind::kBreakage, {{"cause", cause},
                                       {"dynamic_stage", dynamic_stage},
                                       {"creep_time_s", state.creep_time},
                                       {"diameter_m", 0.13e-3 * std::pow(2.8, place)},
                                       {"stress_ratio", 0.8},
                                       {"crack_ratio", 1.0}});
  }
}

void add_stage(Writer& writer, double number, double stage, double begin, const State& state) {
  writer.add(RecordKind::kStage,
             {{"dynamic_stage", number},
              {"stage", stage},
              {"cycles", 20000.0},
              {"creep_time_start_s", begin},
              {"creep_time_end_s", state.creep_time},
              {"axial_strain_end", state.strain},
              {"void_ratio_end", void_ratio(state)},
              {"axial_stress_end_Pa", state.stress},
              {"grading_index_end", grading_index(state)},
              {"ripple", number < 0.0 ? 0.0 : 0.012 + 0.003 * std::fmod(7.0 * number, 5.0)},
              {"broken_at_start", number > 0.0 ? 8.0 : 0.0},
              {"broken_during", number < 0.0 ? 70.0 : 1.0},
              {"particles", 3000.0 + 13.0 * state.broken},
              {"time_step_s", 6.3e-9},
              {"settled", 1.0}});
}

State load(Writer& writer, const SyntheticJob& job) {
  State state;
  state.stress = std::stod(job.axial_stress) * 1e6;
  const double target = state.stress;
  for (int i = 0; i < 5; ++i) {
    State packing{0.0, 0.0, 2e4 * (i + 1), 0.0};
    add_sample(writer, -1.0, 0.0, 0.0, packing);
  }
  state.stress = 1e5;
  add_grading(writer, 0.0, state);
  if (!job.loaded) return state;
  for (int i = 0; i <= 120; ++i) {
    state.stress = 1e5 + (target - 1e5) * i / 120.0;
    state.strain = kStrainBefore * std::pow((state.stress - 1e5) / (target - 1e5), 0.7);
    if (i > 60) add_breakages(writer, 0.0, 0.0, state, 1);
    add_sample(writer, 0.0, 1.0, 0.0, state);
  }
  add_stage(writer, -1.0, 0.0, 0.0, state);
  add_grading(writer, 1.0, state);
  return state;
}

void hold(Writer& writer, const SyntheticJob& job, State state) {
  std::mt19937 bits(job.noise_seed);
  std::normal_distribution<double> normal;
  const double end = std::stod(job.duration) * 86400.0;
  const auto relax = [&](double number, double begin, double strain) {
    const double from = state.strain;
    for (int i = 0; i <= 8; ++i) {
      state.creep_time = begin + kDynamicDuration * i / 8.0;
      state.strain = from + (strain - from) * (1.0 - std::exp(-i)) / (1.0 - std::exp(-8.0));
      add_sample(writer, 1.0, 2.0, number, state);
    }
    add_stage(writer, number, 1.0, begin, state);
    add_grading(writer, number + 2.0, state);
  };
  relax(0.0, kInitialStageEnd - kDynamicDuration, kStrainBefore + 2e-4);
  double strain = state.strain;
  for (int number = 1; number <= job.dynamic_stages; ++number) {
    const double previous = state.creep_time;
    const double part = static_cast<double>(number) / job.dynamic_stages;
    const double next = kInitialStageEnd * std::pow(end / kInitialStageEnd, part);
    const double increment = synthetic_creep_strain(job, next) - synthetic_creep_strain(job, previous);
    strain += increment * std::exp(job.noise * normal(bits));
    state.creep_time = std::max(next - kDynamicDuration, previous);
    add_breakages(writer, 2.0, number, state, 8);
    add_sample(writer, 1.0, 3.0, number, state);
    relax(number, state.creep_time, strain);
  }
}

}  // namespace

double synthetic_creep_strain(const SyntheticJob& job, double creep_time) {
  constexpr double kRateAt1s = 2e-4;
  if (job.m == 1.0) return kRateAt1s * std::log(creep_time / kInitialStageEnd);
  const double power = 1.0 - job.m;
  return kRateAt1s / power * (std::pow(creep_time, power) - std::pow(kInitialStageEnd, power));
}

void write_synthetic_job(const std::filesystem::path& directory, const SyntheticJob& job) {
  std::filesystem::create_directories(directory);
  std::ofstream(directory / "job.toml")
      << "name = \"synthetic <creep>\"\n[specimen]\nparticles = 3000\nvoid_ratio = 0.65\nseed = " << job.seed
      << "\n"
      << "grading = { preset = \"fontainebleau-ne34\" }\n[material]\npreset = \"fontainebleau-ne34\"\n"
      << "[[program]]\nstage = \"oedometric\"\nuntil = { axial_stress = \"" << job.axial_stress << "\" }\n"
      << "[[program]]\nstage = \"creep\"\nduration = \"" << job.duration << "\"\n"
      << "[numerics]\nfidelity = \"paper\"\nminimum_cycles = 20000\n";
  Writer writer(directory);
  const State loaded = load(writer, job);
  if (job.loaded) hold(writer, job, loaded);
  writer.save();
  if (!job.finished) return;
  std::ofstream(directory / "summary.json")
      << R"({"outcome": "completed", "reason": "completed", "figures": {"axial_strain": 0.05, "breakage_hardin": 0.04214,)"
      << R"( "breakage_einav": 0.0931},)"
      << R"( "state_digest": "00c0ffee", "warnings": ["target void ratio not reached"],)"
      << R"( "particle_steps_per_second": 3.2e7, "wall_seconds": 211.5, "threads": 2, "attempts": 1})"
      << "\n";
}

}  // namespace creepctl
