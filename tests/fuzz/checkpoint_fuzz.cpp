// Checkpoints: what is accepted is written again to the same bytes and can be resumed; anything else is
// DataLoss or, with a later version number, FailedPrecondition.
//
// Alterations keep the checksums and the state digest right, or nothing behind them would ever be tried.
#include <bit>
#include <memory>
#include <optional>

#include "core/arithmetic/check.h"
#include "core/arithmetic/digest.h"
#include "core/dem/shear_history.h"
#include "core/experiment/experiment_toml.h"
#include "core/run/run.h"
#include "core/state/checkpoint.h"
#include "tests/fuzz/target.h"

namespace creep::fuzz {
namespace {

constexpr std::string_view kMagic = "CREEPCK\n";
constexpr std::size_t kChecksum = 16;
constexpr std::size_t kMostBytes = 1 << 15;

const Experiment& experiment() {
  static const Experiment kExperiment =
      *parse_experiment(
           "[specimen]\nparticles = 20\n[[program]]\nstage = \"oedometric\"\n"
           "until = { axial_stress = \"1 MPa\" }\n[[program]]\n"
           "stage = \"creep\"\nduration = \"1 d\"\n")
           .experiment;
  return kExperiment;
}

struct Section {
  std::string name;
  std::string bytes;
};

struct Container {
  std::uint64_t version = 0;
  std::vector<Section> sections;

  const std::string& of(std::string_view name) const {
    static const std::string kNone;
    for (const Section& section : sections) {
      if (section.name == name) return section.bytes;
    }
    return kNone;
  }
};

/// Takes values off the front; a value that is not there is zero.
struct Cutter {
  std::string_view bytes;
  bool ok = true;

  std::string_view take(std::uint64_t size) {
    ok = ok && size <= bytes.size();
    const std::string_view front = bytes.substr(0, ok ? size : 0);
    bytes.remove_prefix(front.size());
    return front;
  }
  std::uint64_t number() {
    const std::string_view eight = take(8);
    std::uint64_t value = 0;
    for (std::size_t i = eight.size(); i-- > 0;) value = value << 8 | static_cast<unsigned char>(eight[i]);
    return value;
  }
};

std::optional<Container> split(std::string_view bytes) {
  Cutter cutter{bytes};
  Container container;
  if (cutter.take(kMagic.size()) != kMagic) return std::nullopt;
  container.version = cutter.number();
  while (cutter.ok && !cutter.bytes.empty()) {
    const std::string_view name = cutter.take(cutter.number());
    const std::uint64_t size = cutter.number();
    cutter.take(kChecksum);
    container.sections.push_back({std::string(name), std::string(cutter.take(size))});
  }
  if (!cutter.ok || container.sections.empty()) return std::nullopt;
  return container;
}

void append_number(std::string& out, std::uint64_t value) {
  out.resize(out.size() + 8);
  put_number(out, out.size() - 8, value);
}

/// The section particles without the numbers that say that there are no spins and no forces of walls: the
/// digest of a specimen whose grains neither turn nor are rubbed knows nothing of them.
std::string digested_particles(const Container& container) {
  constexpr std::uint64_t kFirstVersionWithSpins = 4, kFirstVersionWithWallShear = 7;
  const std::string& all = container.of("particles");
  if (container.version < kFirstVersionWithSpins) return all;
  Cutter cutter{all};
  std::uint64_t count = 0;
  for (int column = 0; column < 7; ++column) {
    const std::uint64_t size = std::min<std::uint64_t>(cutter.number(), all.size());
    if (column == 0) count = size;
    cutter.take(8 * size);
  }
  cutter.take(64 * count);  // bodies
  std::string digested = all.substr(0, all.size() - cutter.bytes.size());
  const int lists = container.version < kFirstVersionWithWallShear ? 1 : 2;
  for (int list = 0; list < lists && cutter.ok; ++list) {
    const std::string_view before = cutter.bytes;
    const std::uint64_t size = std::min<std::uint64_t>(cutter.number(), all.size());
    cutter.take((list == 0 ? 24 : 48) * size);
    if (size > 0 || !cutter.ok) digested += before.substr(0, before.size() - cutter.bytes.size());
  }
  return digested.append(cutter.bytes);
}

/// The section surroundings, likewise without the velocities of walls that follow where there are none.
std::string_view digested_surroundings(const Container& container) {
  constexpr std::uint64_t kFirstVersionWithFollowing = 5;
  constexpr std::size_t kFollowing = 3;
  const std::string& all = container.of("surroundings");
  if (container.version < kFirstVersionWithFollowing || all.size() < 8 * kFollowing) return all;
  const std::size_t rest = all.size() - 8 * kFollowing;
  Cutter cutter{std::string_view(all).substr(rest)};
  for (std::size_t axis = 0; axis < kFollowing; ++axis) {
    if (std::bit_cast<double>(cutter.number()) != 0.0) return all;
  }
  return std::string_view(all).substr(0, rest);
}

/// The state digest that these sections call for: the numbers of the state in order, contacts by particle id.
std::string digest_of(const Container& container) {
  Digest digest;
  const std::string particles = digested_particles(container);
  digest.add(std::string_view(particles));
  Cutter ids{particles};
  const std::string_view id = ids.take(8 * std::min<std::uint64_t>(ids.number(), ids.bytes.size() / 8));
  Cutter shear{container.of("shear")};
  digest.add(shear.number());
  while (!shear.bytes.empty() && shear.ok) {
    for (int end = 0; end < 2; ++end) {
      const std::uint64_t place = shear.number();
      digest.add(Cutter{place < id.size() / 8 ? id.substr(8 * place) : id}.number());
    }
    digest.add(shear.take(std::min<std::size_t>(24, shear.bytes.size())));
  }
  digest.add(digested_surroundings(container));
  digest.add(std::string_view(container.of("fines")));
  return digest.hex();
}

/// Puts the digest into the section info, behind the arithmetic and the experiment.
void put_digest(Container& container) {
  const std::string digest = digest_of(container);
  for (Section& section : container.sections) {
    if (section.name != "info") continue;
    Cutter cutter{section.bytes};
    for (int text = 0; text < 2; ++text) cutter.take(cutter.number());
    if (cutter.number() != digest.size() || cutter.take(digest.size()).size() != digest.size()) continue;
    section.bytes.replace(section.bytes.size() - cutter.bytes.size() - digest.size(), digest.size(), digest);
  }
}

std::string sealed(Container container) {
  put_digest(container);
  std::string out(kMagic);
  append_number(out, container.version);
  for (const Section& section : container.sections) {
    append_number(out, section.name.size());
    out += section.name;
    append_number(out, section.bytes.size());
    out += sha256_hex(section.bytes).substr(0, kChecksum);
    out += section.bytes;
  }
  return out;
}

/// Three grains of a run, two contacts, one split, in this act.
std::string small_checkpoint(const std::string& scattered, Act act, bool turning = false,
                             bool rubbed = false) {
  RunState state = *read_checkpoint(scattered);
  CheckpointInfo info = *read_checkpoint_info(scattered);
  Particles& particles = state.specimen.particles;
  for (auto* column : {&particles.mass, &particles.inertial_mass, &particles.limit_stress, &particles.crack,
                       &particles.mobilised_stress}) {
    column->resize(3);
  }
  particles.body.resize(3);
  particles.id.resize(3);
  particles.parent.resize(3);
  particles.generation.resize(3);
  state.specimen.contacts = contacts_from_history(3, {{0, 1, 1.0, 0.0, 0.0}, {1, 2, 0.0, -0.5, 0.25}});
  state.specimen.fines = {{1e-9, 1e-5}};
  if (turning) {
    particles.spin.assign(3, {1e3, 0.0, -0.5, 0.0});
    state.specimen.walls.carried = {-1e-3, 0.0, 0.0};
  }
  if (rubbed) particles.wall_shear.assign(3, {{{0.5, -0.25}, {0.0, 0.0}, {1e-3, 0.0}}});
  const bool packing = std::holds_alternative<PackingState>(act);
  state.stage = packing ? -1 : std::holds_alternative<Loading>(act) ? 0 : 1;
  if (!packing) state.packed = Packed{3, 0.7, 0.1, 0.05};
  if (in_hold(act)) {
    state.hold = Hold{};
    state.hold->promise = Promise{1.0, 2.0};
  }
  state.act = act;
  info.state_digest = creep::digest_of(state);
  return write_checkpoint(state, info);
}

void check_accepted(const std::string& bytes, const RunState& state) {
  const auto info = read_checkpoint_info(bytes);
  CREEP_CHECK(info.ok(), "the head of an accepted checkpoint is refused");
  CREEP_CHECK(creep::digest_of(state) == info->state_digest, "an accepted checkpoint of another state");
  const std::string written = write_checkpoint(state, *info);
  if (info->format_version == kCheckpointVersion) {
    CREEP_CHECK(written == bytes, "an accepted checkpoint is written differently");
  } else {
    const auto again = read_checkpoint(written);
    CREEP_CHECK(again.ok() && creep::digest_of(*again) == info->state_digest,
                "an old checkpoint does not survive being written anew");
  }
  RunOptions options;
  options.allow_inexact = true;
  options.instruction_set = "portable";
  const auto run = Run::resume(experiment(), options, bytes);
  if (!run.ok()) return;
  CREEP_CHECK((*run)->state_digest() == info->state_digest, "a resumed run is of another state");
  CREEP_CHECK((*run)->next_sequence() == info->next_sequence, "a resumed run numbers its records anew");
  static_cast<void>((*run)->progress());
  static_cast<void>((*run)->warnings());
  CREEP_CHECK(read_checkpoint((*run)->checkpoint()).ok(), "a resumed run makes no good checkpoint");
}

}  // namespace

std::vector<std::string> seeds() {
  const std::string scattered = (*Run::start(experiment(), {}))->checkpoint();
  std::vector<std::string> all = {scattered};
  Loading loading;
  loading.next_sample = 1e6;
  DynamicStage stage;
  stage.calm.on_target = 7;
  stage.drift = Drift{300, 2.0, 0.01};
  stage.strain_half_way = 0.01;
  for (const Act& act :
       {Act(PackingState{}), Act(loading), Act(stage), Act(Ageing{}), Act(Between{true}), Act(Done{true})}) {
    all.push_back(small_checkpoint(scattered, act));
  }
  all.push_back(small_checkpoint(scattered, stage, true));
  all.push_back(small_checkpoint(scattered, DynamicStage{}, false, true));
  all.push_back(small_checkpoint(scattered, Loading{}, true, true));
  for (const std::string& one : all) {
    CREEP_CHECK(sealed(*split(one)) == one, "the format has changed: teach split() and digest_of() above");
  }
  return all;
}

void try_input(std::string_view input) {
  const std::string bytes(input);
  const auto state = read_checkpoint(bytes);
  if (state.ok()) return check_accepted(bytes, *state);
  CREEP_CHECK(absl::IsDataLoss(state.status()) || absl::IsFailedPrecondition(state.status()),
              "refused for another reason");
}

std::string altered(std::string_view bytes, Random& random) {
  auto container = split(bytes);
  if (!container || random() % 16 == 0) return mutated(bytes, kMostBytes);
  Section& section = container->sections[random() % container->sections.size()];
  if (random() % 2 == 0 && section.bytes.size() >= 8) {
    put_awkward_number(section.bytes, random);
  } else {
    section.bytes = mutated(section.bytes, kMostBytes);
  }
  if (random() % 32 == 0) container->version = random() % (kCheckpointVersion + 1);
  return sealed(*std::move(container));
}

}  // namespace creep::fuzz
