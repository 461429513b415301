#include "core/output/record.h"

#include <bit>
#include <charconv>
#include <cstring>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "core/arithmetic/check.h"

namespace creep {
namespace {

constexpr Column kSampleColumns[] = {
    {"stage", "1", "Place in the program, from 0; -1 before it"},
    {"phase", "1", "0 packing, 1 loading, 2 dynamic stage, 3 ageing jump"},
    {"dynamic_stage", "1", "Dynamic stages of the present hold begun so far"},
    {"cycle", "1", "Cycles computed since the start of the run"},
    {"age_s", "s", "Laboratory time passed off-DEM"},
    {"dynamic_time_s", "s", "Physical time passed in dynamic computation"},
    {"creep_time_s", "s", "Age plus dynamic time since the hold began; 0 before"},
    {"axial_strain", "1", "Engineering strain along z since the end of packing, compression positive"},
    {"volumetric_strain", "1", "Volume loss over initial volume since the end of packing"},
    {"axial_stress_Pa", "Pa", "Mean stress on top and bottom walls"},
    {"radial_stress_Pa", "Pa", "Mean stress on the four side walls"},
    {"contact_axial_stress_Pa", "Pa", "Axial stress from contact forces (Love-Weber)"},
    {"contact_radial_stress_Pa", "Pa", "Mean lateral stress from contact forces (Love-Weber)"},
    {"void_ratio", "1", "Void ratio, fines booked by splits counted as solid"},
    {"void_ratio_particles", "1", "Void ratio, particles alone counted as solid"},
    {"grading_index", "1", "I_G (eq 13)"},
    {"broken_total", "1", "Particles broken since the start"},
    {"particles", "1", "Particles now"},
    {"coordination_number", "1", "Contacts per particle, walls counted once"},
    {"coordination_number_no_rattlers", "1", "The same over particles with at least two contacts"},
    {"unbalanced_force_ratio", "1", "Mean resultant contact force over mean contact force"},
    {"inertial_number", "1", "Axial strain rate x d50 x sqrt(density / mean stress)"},
    {"time_step_s", "s", "Step in use"},
    {"friction", "1", "Friction between grains in use (lowered while packing)"},
    {"wall_work_J", "J", "Work done on the specimen by the walls since the end of packing"},
    {"normal_elastic_J", "J", "Elastic energy of normal contact forces, closed form"},
    {"tangential_elastic_J", "J", "Elastic energy of tangential contact forces"},
    {"friction_J", "J", "Dissipated by sliding"},
    {"damping_J", "J", "Dissipated by local damping"},
    {"kinetic_J", "J", "Kinetic energy of inertial masses"},
    {"removed_J", "J", "Removed with broken particles"},
    {"tangential_residual_J", "J", "Work of tangential forces neither stored nor dissipated by sliding"},
    {"energy_unexplained_J", "J", "Wall work less the sum of all the above, since the end of packing"},
    {"mass_unexplained", "1", "Mass of particles and fines over the initial mass, less 1"},
    {"mean_stress_Pa", "Pa", "p = (axial + 2 radial stress) / 3, from wall forces"},
    {"deviatoric_stress_Pa", "Pa", "q = axial - radial stress, from wall forces"},
};
constexpr std::size_t kSampleColumnsBeforeStress = std::size(kSampleColumns) - 2;

constexpr Column kStageColumns[] = {
    {"dynamic_stage", "1", "Number in its hold, from 0 (the initial one); -1 for a loading stage"},
    {"stage", "1", "Place in the program, from 0"},
    {"cycles", "1", "Cycles computed"},
    {"creep_time_start_s", "s", "creep_time when it began"},
    {"creep_time_end_s", "s", "creep_time when it ended"},
    {"age_s", "s", "Laboratory time passed off-DEM"},
    {"dynamic_time_s", "s", "Physical dynamic time at its end"},
    {"suspended_time_s", "s",
     "Dynamic time of this stage in which crack growth was suspended (inertia scaled)"},
    {"axial_strain_end", "1", "At its end"},
    {"void_ratio_end", "1", "At its end"},
    {"axial_stress_end_Pa", "Pa", "At its end"},
    {"grading_index_end", "1", "At its end"},
    {"ripple", "1", "Largest |stress/target - 1| of walls that hold a stress; 0 for a loading stage"},
    {"broken_at_start", "1", "Particles broken by the ageing jump that opened it"},
    {"broken_during", "1", "Particles broken while it ran"},
    {"unbalanced_force_ratio", "1", "At its end"},
    {"time_step_s", "s", "At its end"},
    {"particles", "1", "At its end"},
    {"settled", "1", "1 if it ended in equilibrium"},
};

constexpr Column kBreakageColumns[] = {
    {"particle", "1", "Id of the failed particle"},
    {"cause", "1", "0 immediate, 1 crack in a dynamic stage, 2 crack in ageing"},
    {"dynamic_stage", "1", "Dynamic stages of the present hold begun so far"},
    {"cycle", "1", "Cycles computed since the start of the run"},
    {"age_s", "s", "Laboratory time passed off-DEM"},
    {"dynamic_time_s", "s", "Physical dynamic time"},
    {"creep_time_s", "s", "creep_time"},
    {"diameter_m", "m", "Of the failed particle"},
    {"generation", "1", "0 for an initial particle"},
    {"x_m", "m", "Centre"},
    {"y_m", "m", "Centre"},
    {"z_m", "m", "Centre"},
    {"stress_ratio", "1", "sigma_mob / sigma_lim at failure"},
    {"crack_ratio", "1", "Crack half-length over radius at failure"},
};

constexpr Column kGradingColumns[] = {
    {"curve", "1",
     "Number of the curve, from 0: 0 the initial specimen, then one at each end of a dynamic stage"},
    {"creep_time_s", "s", "creep_time; 0 before a hold"},
    {"diameter_m", "m", "Particle diameter"},
    {"passing", "1", "Mass fraction finer, fines included"},
};

/// Rows of earlier versions end before p and q, which follow from the others.
void add_mean_and_deviatoric_stress(std::vector<double>& sample) {
  const double axial = sample[column_index(RecordKind::kSample, "axial_stress_Pa")];
  const double radial = sample[column_index(RecordKind::kSample, "radial_stress_Pa")];
  sample.push_back((axial + 2.0 * radial) / 3.0);
  sample.push_back(axial - radial);
}

void put(std::string& out, std::uint64_t value, int bytes) {
  for (int i = 0; i < bytes; ++i) out.push_back(static_cast<char>((value >> (8 * i)) & 0xffu));
}

std::uint64_t get(std::string_view in, int bytes) {
  std::uint64_t value = 0;
  for (int i = 0; i < bytes; ++i) {
    value |= static_cast<std::uint64_t>(static_cast<unsigned char>(in[static_cast<std::size_t>(i)]))
             << (8 * i);
  }
  return value;
}

constexpr std::size_t kHead = 1 + 8 + 4;

}  // namespace

std::span<const Column> columns(RecordKind kind) {
  switch (kind) {
    case RecordKind::kSample:
      return kSampleColumns;
    case RecordKind::kStage:
      return kStageColumns;
    case RecordKind::kBreakage:
      return kBreakageColumns;
    case RecordKind::kGrading:
      return kGradingColumns;
  }
  return {};
}

std::size_t column_index(RecordKind kind, std::string_view name) {
  const auto all = columns(kind);
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (all[i].name == name) return i;
  }
  CREEP_CHECK(false, "unknown column");
  return 0;
}

std::string_view phase_name(Phase phase) {
  switch (phase) {
    case Phase::kPacking:
      return "packing";
    case Phase::kLoading:
      return "loading";
    case Phase::kDynamicStage:
      return "dynamic stage";
    case Phase::kAgeing:
      return "ageing";
  }
  return "";
}

std::string encode(const Record& record) {
  std::string out;
  out.reserve(kHead + 8 * record.values.size());
  put(out, static_cast<std::uint64_t>(record.kind), 1);
  put(out, record.sequence, 8);
  put(out, record.values.size(), 4);
  for (const double value : record.values) put(out, std::bit_cast<std::uint64_t>(value), 8);
  return out;
}

absl::StatusOr<Record> decode(std::string_view bytes) {
  if (bytes.size() < kHead) return absl::DataLossError("record shorter than its head");
  Record record;
  record.kind = static_cast<RecordKind>(static_cast<unsigned char>(bytes[0]));
  const auto expected = columns(record.kind);
  if (expected.empty()) return absl::DataLossError("record of unknown kind");
  record.sequence = get(bytes.substr(1), 8);
  const std::uint64_t count = get(bytes.substr(9), 4);
  const bool older = record.kind == RecordKind::kSample && count == kSampleColumnsBeforeStress;
  if ((count != expected.size() && !older) || bytes.size() != kHead + 8 * count) {
    return absl::DataLossError(
        absl::StrCat("record with ", count, " values where ", expected.size(), " belong"));
  }
  record.values.resize(count);
  for (std::size_t i = 0; i < count; ++i) {
    record.values[i] = std::bit_cast<double>(get(bytes.substr(kHead + 8 * i), 8));
  }
  if (older) add_mean_and_deviatoric_stress(record.values);
  return record;
}

std::string csv_header(RecordKind kind) {
  std::string line = "sequence";
  for (const Column& column : columns(kind)) {
    line += ',';
    line += column.name;
  }
  return line;
}

std::string csv_row(const Record& record) {
  std::string line = std::to_string(record.sequence);
  for (const double value : record.values) {
    char text[40];
    const auto end = std::to_chars(text, text + sizeof text, value).ptr;
    line += ',';
    line.append(text, end);
  }
  return line;
}

}  // namespace creep
