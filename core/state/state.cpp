#include "core/state/state.h"

#include <array>
#include <bit>
#include <cstring>
#include <type_traits>
#include <utility>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "core/arithmetic/digest.h"
#include "core/dem/shear_history.h"

namespace creep {
namespace {

constexpr std::string_view kMagic = "CREEPCK\n";
constexpr std::size_t kChecksum = 16;  // hex digits of the SHA-256 of a section

/// Appends values to a section.
class Writer {
 public:
  static constexpr bool kReading = false;
  void operator()(const double& value) { bits(std::bit_cast<std::uint64_t>(value)); }
  void operator()(const bool& value) { bits(value ? 1 : 0); }
  template <class T>
  requires std::is_integral_v<T> || std::is_enum_v<T>
  void operator()(const T& value) { bits(static_cast<std::uint64_t>(value)); }
  void operator()(const std::string& value) {
    bits(value.size());
    bytes_ += value;
  }
  void operator()(const FixedSum& sum) {
    (*this)(sum.high());
    (*this)(sum.low());
    (*this)(sum.saturated());
  }
  template <class T>
  void array(const std::vector<T>& values) {
    bits(values.size());
    for (const T& value : values) (*this)(value);
  }
  const std::string& bytes() const { return bytes_; }

 private:
  void bits(std::uint64_t value) {
    for (int i = 0; i < 8; ++i) bytes_.push_back(static_cast<char>(value >> (8 * i) & 0xffu));
  }
  std::string bytes_;
};

/// Takes values from a section; after a shortage every value is zero and ok() false, as after a value that
/// does not fit its type.
class Reader {
 public:
  static constexpr bool kReading = true;
  explicit Reader(std::string_view bytes) : bytes_(bytes) {}
  void operator()(double& value) { value = std::bit_cast<double>(bits()); }
  template <class T>
  requires std::is_integral_v<T> || std::is_enum_v<T>
  void operator()(T& value) {
    const std::uint64_t all = bits();
    value = static_cast<T>(all);
    ok_ = ok_ && static_cast<std::uint64_t>(value) == all;
  }
  void operator()(std::string& value) {
    const std::uint64_t size = bits();
    if (size > bytes_.size()) {
      ok_ = false;
      return;
    }
    value = std::string(bytes_.substr(0, size));
    bytes_.remove_prefix(size);
  }
  void operator()(FixedSum& sum) {
    std::int64_t high = 0, low = 0;
    bool saturated = false;
    (*this)(high);
    (*this)(low);
    (*this)(saturated);
    sum = FixedSum::from_halves(sum.quantum_exponent(), high, low, saturated);
  }
  template <class T>
  void array(std::vector<T>& values) {
    const std::uint64_t count = bits();
    // Every element takes at least 8 bytes, so a count beyond the section is damage, found before allocating.
    if (count > bytes_.size() / 8) {
      ok_ = false;
      return;
    }
    values.resize(count);
    for (T& value : values) (*this)(value);
  }
  bool done() const { return ok_ && bytes_.empty(); }
  bool ok() const { return ok_; }

 private:
  std::uint64_t bits() {
    if (bytes_.size() < 8) {
      ok_ = false;
      bytes_ = {};
      return 0;
    }
    std::uint64_t value = 0;
    for (std::size_t i = 0; i < 8; ++i)
      value |= std::uint64_t{static_cast<unsigned char>(bytes_[i])} << (8 * i);
    bytes_.remove_prefix(8);
    return value;
  }
  std::string_view bytes_;
  bool ok_ = true;
};

/// Adds values to a digest.
class Digester {
 public:
  static constexpr bool kReading = false;
  void operator()(const double& value) { digest_.add(value); }
  template <class T>
  requires std::is_integral_v<T> || std::is_enum_v<T>
  void operator()(const T& value) { digest_.add(static_cast<std::uint64_t>(value)); }
  template <class T>
  void array(const std::vector<T>& values) {
    digest_.add(static_cast<std::uint64_t>(values.size()));
    for (const T& value : values) (*this)(value);
  }
  std::string hex() const { return digest_.hex(); }

 private:
  Digest digest_;
};

// Each visit names every field once, for writing, reading and digesting alike. `Of` is T or const T.

template <class Archive, class Of>
void visit_particles(Archive& archive, Of& particles) {
  archive.array(particles.id);
  archive.array(particles.parent);
  archive.array(particles.generation);
  archive.array(particles.mass);
  archive.array(particles.inertial_mass);
  archive.array(particles.limit_stress);
  archive.array(particles.crack);
  if constexpr (Archive::kReading) particles.body.resize(particles.id.size());
  for (auto& body : particles.body) {
    archive(body.x);
    archive(body.y);
    archive(body.z);
    archive(body.radius);
    archive(body.vx);
    archive(body.vy);
    archive(body.vz);
    archive(body.breaking_stress);
  }
}

template <class Archive, class Of>
void visit_spin(Archive& archive, Of& spins) {
  std::uint64_t count = spins.size();
  archive(count);
  if constexpr (Archive::kReading) {
    spins.clear();
    for (std::uint64_t k = 0; k < count && archive.ok(); ++k) {
      Spin spin{};
      archive(spin.x);
      archive(spin.y);
      archive(spin.z);
      spins.push_back(spin);
    }
  } else {
    for (const Spin& spin : spins) {
      archive(spin.x);
      archive(spin.y);
      archive(spin.z);
    }
  }
}

template <class Archive, class Of>
void visit_wall_shear(Archive& archive, Of& shears) {
  std::uint64_t count = shears.size();
  archive(count);
  if constexpr (Archive::kReading) {
    shears.clear();
    for (std::uint64_t k = 0; k < count && archive.ok(); ++k) {
      WallShear shear{};
      for (auto& wall : shear.across)
        for (auto& force : wall) archive(force);
      shears.push_back(shear);
    }
  } else {
    for (const WallShear& shear : shears)
      for (const auto& wall : shear.across)
        for (const double& force : wall) archive(force);
  }
}

template <class Archive, class Of>
void visit_shear(Archive& archive, Of& history) {
  std::uint64_t count = history.size();
  archive(count);
  if constexpr (Archive::kReading) {
    history.clear();
    for (std::uint64_t k = 0; k < count && archive.ok(); ++k) {
      PairShear pair;
      archive(pair.first);
      archive(pair.second);
      archive(pair.x);
      archive(pair.y);
      archive(pair.z);
      history.push_back(pair);
    }
  } else {
    for (const PairShear& pair : history) {
      archive(pair.first);
      archive(pair.second);
      archive(pair.x);
      archive(pair.y);
      archive(pair.z);
    }
  }
}

template <class Archive, class Of>
void visit_surroundings(Archive& archive, Of& specimen) {
  for (auto& value : specimen.walls.position) archive(value);
  for (auto& value : specimen.walls.velocity) archive(value);
  for (auto& value : specimen.walls.force) archive(value);
  for (auto& value : specimen.walls.stiffness) archive(value);
  archive(specimen.clocks.age);
  archive(specimen.clocks.dynamic_time);
  archive(specimen.clocks.suspended_time);
  archive(specimen.clocks.hold_start);
  archive(specimen.initial_mass);
  archive(specimen.initial_height);
  archive(specimen.initial_volume);
  archive(specimen.friction);
  archive(specimen.time_step);
  archive(specimen.last_time_step);
  archive(specimen.crack_time);
  archive(specimen.unbalanced_force_ratio);
  archive(specimen.mean_overlap);
  archive(specimen.next_id);
  archive(specimen.cycle);
  archive(specimen.broken_total);
}

template <class Archive, class Of>
void visit_carried(Archive& archive, Of& carried) {
  for (auto& velocity : carried) archive(velocity);
}

template <class Archive, class Of>
void visit_fines(Archive& archive, Of& fines) {
  std::uint64_t count = fines.size();
  archive(count);
  if constexpr (Archive::kReading) {
    fines.clear();
    for (std::uint64_t k = 0; k < count && archive.ok(); ++k) {
      Fines one;
      archive(one.mass);
      archive(one.smallest_sibling);
      fines.push_back(one);
    }
  } else {
    for (const Fines& one : fines) {
      archive(one.mass);
      archive(one.smallest_sibling);
    }
  }
}

template <class Archive, class Of>
void visit_energy(Archive& archive, Of& energy) {
  archive(energy.wall_work);
  archive(energy.tangential_work);
  archive(energy.friction);
  archive(energy.damping);
  archive(energy.removed_normal);
  archive(energy.removed_tangential);
  archive(energy.removed_kinetic);
  archive(energy.initial_stored);
  archive(energy.initial_tangential);
}

template <class Archive, class OfPacking, class OfCursor>
void visit_cursor(Archive& archive, OfPacking& packing, OfCursor& cursor, std::uint64_t version) {
  archive(packing.step);
  archive(packing.growth);
  archive(packing.step_cycle);
  archive(packing.quiet_since);
  archive(packing.lowest_void_ratio);
  archive(packing.stop_void_ratio);
  archive(packing.falls);
  archive(packing.generation_friction);
  archive(cursor.act);
  archive(cursor.stage);
  archive(cursor.dynamic_stage);
  archive(cursor.closing);
  archive(cursor.target);
  archive(cursor.sample_at);
  archive(cursor.stage_cycle);
  archive(cursor.quiet_since);
  archive(cursor.ripple);
  archive(cursor.creep_time_start);
  archive(cursor.suspended_start);
  archive(cursor.broken_at_start);
  archive(cursor.broken_before);
  archive(cursor.curves);
  archive(cursor.initial_count);
  archive(cursor.ageing_jumps);
  archive(cursor.dynamic_stages);
  archive(cursor.void_ratio_reached);
  archive(cursor.void_ratio_loaded);
  archive(cursor.strain_loaded);
  archive(cursor.initial_grading_index);
  archive(cursor.largest_ripple);
  archive(cursor.broken_loaded);
  if (version < 2) return;
  archive(cursor.age_loaded);
  archive(cursor.next_snapshot_age);
  if (version < 3) return;
  archive(cursor.sides);
  archive(cursor.radial_target);
  archive(cursor.holding);
  archive(cursor.stress_loaded);
  archive(cursor.strain_half_way);
  archive(cursor.reached_cycle);
  archive(cursor.loading_start);
  archive(cursor.peak_deviatoric_stress);
  archive(cursor.strain_at_peak);
  archive(cursor.kept);
  if (version < 6) return;
  archive(cursor.drift_cycle);
  archive(cursor.drift_reference);
  archive(cursor.drift);
  archive(cursor.breakages);
  archive(cursor.promised);
  archive(cursor.aged_from);
}

template <class Archive, class Of>
void visit_info(Archive& archive, Of& info, std::uint64_t version) {
  archive(info.arithmetic_id);
  archive(info.experiment_hash);
  archive(info.state_digest);
  archive(info.next_sequence);
  archive(info.stage);
  archive(info.particles);
  archive(info.cycle);
  archive(info.age);
  archive(info.dynamic_time);
  archive(info.creep_time);
  archive(info.axial_strain);
  archive(info.broken_total);
  archive(info.inexact);
  if (version < 3) return;
  archive(info.specimen_hash);
  archive(info.start_digest);
  archive(info.finished);
}

constexpr std::string_view kSections[] = {"info",  "particles", "shear", "surroundings",
                                          "fines", "energy",    "cursor"};

void append_section(std::string& out, std::string_view name, const Writer& section) {
  Writer head;
  head(std::string(name));
  head(section.bytes().size());
  out += head.bytes();
  out += sha256_hex(section.bytes()).substr(0, kChecksum);
  out += section.bytes();
}

/// A number above it is damage, not a format to come.
constexpr std::uint64_t kLastPossibleVersion = 0xffff;

struct Verified {
  std::uint64_t version = 0;
  std::vector<std::string_view> sections;
};

/// Splits a checkpoint into its sections, in the fixed order, each verified.
absl::StatusOr<Verified> verified_sections(std::string_view bytes) {
  if (bytes.substr(0, kMagic.size()) != kMagic)
    return absl::DataLossError("not a checkpoint: wrong first bytes");
  bytes.remove_prefix(kMagic.size());
  const auto take = [&](std::uint64_t& value) {
    if (bytes.size() < 8) return false;
    Reader reader(bytes.substr(0, 8));
    reader(value);
    bytes.remove_prefix(8);
    return true;
  };
  Verified verified;
  if (take(verified.version) && verified.version > kCheckpointVersion &&
      verified.version <= kLastPossibleVersion) {
    return absl::FailedPreconditionError(absl::StrCat("checkpoint format ", verified.version,
                                                      " was made by a newer program; this one reads 1 to ",
                                                      kCheckpointVersion));
  }
  if (verified.version < 1 || verified.version > kCheckpointVersion) {
    return absl::DataLossError(absl::StrCat("checkpoint format ", verified.version,
                                            ", this program reads 1 to ", kCheckpointVersion));
  }
  for (const std::string_view expected : kSections) {
    const auto cut = [&] {
      return absl::DataLossError(absl::StrCat("checkpoint cut short at section ", std::string(expected)));
    };
    std::uint64_t name_size = 0, size = 0;
    if (!take(name_size) || name_size > bytes.size()) return cut();
    if (bytes.substr(0, name_size) != expected) {
      return absl::DataLossError(
          absl::StrCat("checkpoint without section ", std::string(expected), " in its place"));
    }
    bytes.remove_prefix(name_size);
    if (!take(size) || bytes.size() < kChecksum || bytes.size() - kChecksum < size) return cut();
    const std::string_view checksum = bytes.substr(0, kChecksum);
    const std::string_view section = bytes.substr(kChecksum, size);
    if (sha256_hex(section).substr(0, kChecksum) != checksum) {
      return absl::DataLossError(
          absl::StrCat("checkpoint damaged: wrong checksum of section ", std::string(expected)));
    }
    verified.sections.push_back(section);
    bytes.remove_prefix(kChecksum + size);
  }
  if (!bytes.empty()) return absl::DataLossError("checkpoint followed by bytes that do not belong to it");
  return verified;
}

absl::Status consistent(const RunState& state, const std::vector<PairShear>& history) {
  const Cursor& cursor = state.cursor;
  const bool in_stage = cursor.act != Cursor::Act::kPacking && cursor.act != Cursor::Act::kStart;
  if (cursor.act > Cursor::kLastAct || cursor.sides > Cursor::Sides::kHeld ||
      state.packing.step > PackingState::Step::kDone || cursor.stage < (in_stage ? 0 : -1)) {
    return absl::DataLossError("checkpoint that stands nowhere in a program");
  }
  const Particles& particles = state.specimen.particles;
  const std::size_t n = particles.id.size();
  if (particles.parent.size() != n || particles.generation.size() != n || particles.mass.size() != n ||
      particles.inertial_mass.size() != n || particles.limit_stress.size() != n ||
      particles.crack.size() != n || (!particles.spin.empty() && particles.spin.size() != n) ||
      (!particles.wall_shear.empty() && particles.wall_shear.size() != n)) {
    return absl::DataLossError("checkpoint with particle columns of different lengths");
  }
  for (std::size_t k = 0; k < history.size(); ++k) {
    const PairShear& pair = history[k];
    if (pair.first < 0 || pair.second <= pair.first || static_cast<std::size_t>(pair.second) >= n) {
      return absl::DataLossError("checkpoint with a contact between particles that are not there");
    }
    if (k > 0 &&
        std::pair(pair.first, pair.second) <= std::pair(history[k - 1].first, history[k - 1].second)) {
      return absl::DataLossError("checkpoint with contacts out of order");
    }
  }
  return absl::OkStatus();
}

}  // namespace

std::string digest_of(const RunState& state) {
  Digester digest;
  visit_particles(digest, state.specimen.particles);
  if (!state.specimen.particles.spin.empty()) visit_spin(digest, state.specimen.particles.spin);
  if (!state.specimen.particles.wall_shear.empty()) {
    visit_wall_shear(digest, state.specimen.particles.wall_shear);
  }
  const std::vector<PairShear> history = shear_history(state.specimen.contacts);
  digest(static_cast<std::uint64_t>(history.size()));
  for (const PairShear& pair : history) {
    digest(state.specimen.particles.id[static_cast<std::size_t>(pair.first)]);
    digest(state.specimen.particles.id[static_cast<std::size_t>(pair.second)]);
    digest(pair.x);
    digest(pair.y);
    digest(pair.z);
  }
  visit_surroundings(digest, state.specimen);
  if (state.specimen.walls.carried != std::array<double, 3>{}) {
    visit_carried(digest, state.specimen.walls.carried);
  }
  visit_fines(digest, state.specimen.fines);
  return digest.hex();
}

std::string write_checkpoint(const RunState& state, const CheckpointInfo& info) {
  std::string out(kMagic);
  Writer version;
  version(kCheckpointVersion);
  out += version.bytes();
  Writer section[7];
  visit_info(section[0], info, kCheckpointVersion);
  visit_particles(section[1], state.specimen.particles);
  visit_spin(section[1], state.specimen.particles.spin);
  visit_wall_shear(section[1], state.specimen.particles.wall_shear);
  const std::vector<PairShear> history = shear_history(state.specimen.contacts);
  visit_shear(section[2], history);
  visit_surroundings(section[3], state.specimen);
  visit_carried(section[3], state.specimen.walls.carried);
  visit_fines(section[4], state.specimen.fines);
  visit_energy(section[5], state.specimen.energy);
  visit_cursor(section[6], state.packing, state.cursor, kCheckpointVersion);
  for (std::size_t s = 0; s < 7; ++s) append_section(out, kSections[s], section[s]);
  return out;
}

absl::StatusOr<RunState> read_checkpoint(std::string_view bytes) {
  const absl::StatusOr<Verified> verified = verified_sections(bytes);
  if (!verified.ok()) return verified.status();
  std::vector<Reader> reader;
  for (const std::string_view section : verified->sections) reader.emplace_back(section);
  RunState state;
  CheckpointInfo info;
  std::vector<PairShear> history;
  visit_info(reader[0], info, verified->version);
  visit_particles(reader[1], state.specimen.particles);
  if (verified->version >= 4) visit_spin(reader[1], state.specimen.particles.spin);
  if (verified->version >= 7) visit_wall_shear(reader[1], state.specimen.particles.wall_shear);
  visit_shear(reader[2], history);
  visit_surroundings(reader[3], state.specimen);
  if (verified->version >= 5) visit_carried(reader[3], state.specimen.walls.carried);
  visit_fines(reader[4], state.specimen.fines);
  visit_energy(reader[5], state.specimen.energy);
  visit_cursor(reader[6], state.packing, state.cursor, verified->version);
  for (std::size_t s = 0; s < reader.size(); ++s) {
    if (!reader[s].done()) {
      return absl::DataLossError(
          absl::StrCat("checkpoint section ", std::string(kSections[s]), " does not hold what it should"));
    }
  }
  if (absl::Status status = consistent(state, history); !status.ok()) return status;
  state.specimen.particles.mobilised_stress.assign(state.specimen.particles.size(), 0.0);
  state.specimen.contacts = contacts_from_history(state.specimen.particles.size(), history);
  state.next_sequence = info.next_sequence;
  state.inexact = info.inexact;
  state.start_digest = info.start_digest;
  if (verified->version < 3) {
    state.cursor.holding =
        state.cursor.act == Cursor::Act::kDynamicStage || state.cursor.act == Cursor::Act::kAgeing;
  }
  if (digest_of(state) != info.state_digest)
    return absl::DataLossError("checkpoint does not match its state digest");
  return state;
}

absl::StatusOr<CheckpointInfo> read_checkpoint_info(std::string_view checkpoint) {
  const absl::StatusOr<Verified> verified = verified_sections(checkpoint);
  if (!verified.ok()) return verified.status();
  Reader reader(verified->sections.front());
  CheckpointInfo info;
  visit_info(reader, info, verified->version);
  if (!reader.done()) return absl::DataLossError("checkpoint section info does not hold what it should");
  info.format_version = static_cast<std::uint32_t>(verified->version);
  return info;
}

}  // namespace creep
