#include "core/state/checkpoint.h"

#include <array>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "core/arithmetic/digest.h"
#include "core/dem/shear_history.h"
#include "core/state/archive.h"
#include "core/state/format_7.h"
#include "core/state/layout.h"

namespace creep {
namespace {

constexpr std::string_view kMagic = "CREEPCK\n";
constexpr std::size_t kChecksum = 16;  // hex digits of the SHA-256 of a section

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
  const auto* packing = std::get_if<PackingState>(&state.act);
  const bool before_program = packing != nullptr || std::holds_alternative<Starting>(state.act);
  if (state.aim.sides > Aim::Sides::kHeld || state.stage < (before_program ? -1 : 0) ||
      (packing != nullptr && packing->step > PackingState::Step::kDone) ||
      state.packed.has_value() == (packing != nullptr) || (in_hold(state.act) && !state.hold)) {
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
  visit_run(section[6], state);
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
  if (verified->version >= 8) {
    visit_run(reader[6], state);
  } else if (!read_format_7(reader[6], verified->version, state)) {
    reader[6].refuse();
  }
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
