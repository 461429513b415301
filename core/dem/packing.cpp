#include "core/dem/packing.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "absl/strings/str_cat.h"
#include "core/arithmetic/check.h"
#include "core/arithmetic/elementary.h"
#include "core/arithmetic/random.h"
#include "core/dem/measures.h"
#include "core/dem/particle_birth.h"
#include "core/dem/shear_history.h"
#include "core/physics/grading.h"

namespace creep {
namespace {

constexpr double kFirstGrowth = 0.5;   // radius over final radius at the start [-]
constexpr double kGrowthStep = 1.005;  // of the radius, every kGrowthCycles
constexpr std::int64_t kGrowthCycles = 20;
constexpr double kLooser = 0.30;  // void ratio of the first box above the target [-]
constexpr double kPackingVelocity =
    0.5;                                // closing speed of a pair of walls [m/s]; inertial number about 4e-3
constexpr double kFirstFriction = 0.5;  // [-]
constexpr std::int64_t kFrictionHalving = 5000;  // cycles in which friction halves
constexpr double kFirstMargin = 0.01;   // void ratio above the target at which the first fall ends [-]
constexpr double kCloseEnough = 0.001;  // of the target void ratio: no further fall [-]
constexpr std::int64_t kMostFalls = 12;
constexpr double kLeastFriction = 1e-3;      // below it: zero [-]
constexpr double kRestoreUnbalanced = 1e-3;  // unbalanced force ratio at which packing ends [-]
constexpr std::int64_t kQuietCycles = 2000;
constexpr std::int64_t kMostCycles = 400000;  // of one step

std::int64_t count_for_side(const Experiment& experiment, double side) {
  const double mean_volume = std::numbers::pi / 6.0 * mean_cubed_diameter(experiment.specimen.grading);
  const double solid = side * side * side / (1.0 + experiment.specimen.void_ratio);
  return std::max<std::int64_t>(1, std::llround(solid / mean_volume));
}

/// Random sequential addition, large to small, on a grid of the largest diameter.
class Scatter {
 public:
  Scatter(double side, double largest_diameter, std::uint64_t seed)
      : side_(side), seed_(seed), cells_(std::max(1, static_cast<int>(side / largest_diameter))) {
    head_.resize(static_cast<std::size_t>(cells_) * static_cast<std::size_t>(cells_) *
                 static_cast<std::size_t>(cells_));
  }

  std::array<double, 3> place(std::uint64_t id, double radius) {
    constexpr std::uint32_t kMostTries = 100000;
    for (std::uint32_t attempt = 0; attempt < kMostTries; ++attempt) {
      std::array<double, 3> centre{};
      for (std::uint32_t axis = 0; axis < 3; ++axis) {
        centre[axis] =
            radius + (side_ - 2.0 * radius) * uniform(seed_, id, RandomEvent::kPosition, 3 * attempt + axis);
      }
      if (free(centre, radius)) {
        head_[cell_of(centre)].push_back({centre, radius});
        return centre;
      }
    }
    CREEP_CHECK(false, "no room for a particle in a box chosen to be loose");
    return {};
  }

 private:
  struct Placed {
    std::array<double, 3> centre;
    double radius;
  };
  int cell(double coordinate) const {
    return std::clamp(static_cast<int>(coordinate / side_ * cells_), 0, cells_ - 1);
  }
  std::size_t flat(int x, int y, int z) const {
    return (static_cast<std::size_t>(z) * static_cast<std::size_t>(cells_) + static_cast<std::size_t>(y)) *
               static_cast<std::size_t>(cells_) +
           static_cast<std::size_t>(x);
  }
  std::size_t cell_of(const std::array<double, 3>& c) const {
    return flat(cell(c[0]), cell(c[1]), cell(c[2]));
  }
  bool free(const std::array<double, 3>& centre, double radius) const {
    int low[3], high[3];
    for (std::size_t axis = 0; axis < 3; ++axis) {
      low[axis] = std::max(0, cell(centre[axis]) - 1);
      high[axis] = std::min(cells_ - 1, cell(centre[axis]) + 1);
    }
    for (int z = low[2]; z <= high[2]; ++z) {
      for (int y = low[1]; y <= high[1]; ++y) {
        for (int x = low[0]; x <= high[0]; ++x) {
          for (const Placed& other : head_[flat(x, y, z)]) {
            double squared = 0.0;
            for (std::size_t axis = 0; axis < 3; ++axis) {
              squared += (other.centre[axis] - centre[axis]) * (other.centre[axis] - centre[axis]);
            }
            if (squared < (other.radius + radius) * (other.radius + radius)) return false;
          }
        }
      }
    }
    return true;
  }

  double side_;
  std::uint64_t seed_;
  int cells_;
  std::vector<std::vector<Placed>> head_;
};

/// Bits of three 21-bit numbers interleaved.
std::uint64_t interleave(std::uint64_t x, std::uint64_t y, std::uint64_t z) {
  std::uint64_t code = 0;
  for (int bit = 20; bit >= 0; --bit) {
    code = code << 3 | (z >> bit & 1u) << 2 | (y >> bit & 1u) << 1 | (x >> bit & 1u);
  }
  return code;
}

/// Gives ids 0 .. n-1 along a space-filling curve and draws strengths and cracks by them.
void name_particles(Specimen& specimen, const Experiment& experiment) {
  const Particles old = specimen.particles;
  std::vector<std::pair<std::uint64_t, std::size_t>> order(old.size());
  constexpr double kSteps = 1 << 10;
  for (std::size_t i = 0; i < old.size(); ++i) {
    std::uint64_t place[3];
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double fraction =
          (old.position(i)[static_cast<Eigen::Index>(axis)] - specimen.walls.position[2 * axis]) /
          specimen.walls.length(axis);
      place[axis] = static_cast<std::uint64_t>(std::clamp(fraction, 0.0, 1.0) * kSteps);
    }
    order[i] = {interleave(place[0], place[1], place[2]), i};
  }
  std::sort(order.begin(), order.end());
  std::vector<std::int32_t> place_of(old.size());
  for (std::size_t k = 0; k < order.size(); ++k) place_of[order[k].second] = static_cast<std::int32_t>(k);
  std::vector<PairShear> shears = shear_history(specimen.contacts);
  for (PairShear& pair : shears) {
    pair.first = place_of[static_cast<std::size_t>(pair.first)];
    pair.second = place_of[static_cast<std::size_t>(pair.second)];
    if (pair.first < pair.second) continue;
    std::swap(pair.first, pair.second);
    pair.x = -pair.x;
    pair.y = -pair.y;
    pair.z = -pair.z;
  }
  std::sort(shears.begin(), shears.end(), [](const PairShear& l, const PairShear& r) {
    return l.first != r.first ? l.first < r.first : l.second < r.second;
  });
  specimen.particles = Particles{};
  for (const auto& [code, i] : order) {
    const Body& body = old.body[i];
    Birth birth;
    birth.id = birth.parent = specimen.particles.size();
    birth.radius = body.radius;
    const double position[3] = {body.x, body.y, body.z}, velocity[3] = {body.vx, body.vy, body.vz};
    std::copy(position, position + 3, birth.position);
    std::copy(velocity, velocity + 3, birth.velocity);
    if (experiment.material.free_rotation) {
      const double spin[3] = {old.spin[i].x, old.spin[i].y, old.spin[i].z};
      std::copy(spin, spin + 3, birth.spin);
    }
    append_particle(specimen.particles, experiment, birth);
  }
  specimen.next_id = specimen.particles.size();
  specimen.contacts = contacts_from_history(specimen.particles.size(), shears);
}

void start_step(PackingState& state, PackingState::Step step) {
  state.step = step;
  state.step_cycle = 0;
  state.quiet_since = 0;
}

WallControl isotropic(const Experiment& experiment, bool fixed) {
  WallControl control{};
  for (AxisControl& axis : control) {
    axis.mode = fixed ? AxisControl::Mode::kFixed : AxisControl::Mode::kServo;
    axis.stress = experiment.specimen.isotropic_stress;
    axis.closing_velocity = kPackingVelocity;
  }
  return control;
}

bool on_target(const Specimen& specimen, double stress, double tolerance) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (!(std::fabs(specimen.walls.stress(axis) / stress - 1.0) < tolerance)) return false;
  }
  return true;
}

/// Local damping does nothing to a particle without force, so free flight is stopped by hand.
void stop_free_flight(Particles& particles) {
  for (std::size_t i = 0; i < particles.size(); ++i) {
    if (particles.mobilised_stress[i] == 0.0) {
      particles.body[i].vx = particles.body[i].vy = particles.body[i].vz = 0.0;
      if (!particles.spin.empty()) particles.spin[i] = Spin{};
    }
  }
}

/// Grows all radii; the box is loose and at rest meanwhile, and every step starts from rest.
void grow(Specimen& specimen, PackingState& state, const Experiment& experiment, Dynamics& dynamics) {
  const double next = std::min(1.0, state.growth * kGrowthStep);
  const double factor = next / state.growth;
  for (std::size_t i = 0; i < specimen.particles.size(); ++i) {
    Body& body = specimen.particles.body[i];
    body.radius *= factor;
    body.vx = body.vy = body.vz = 0.0;
    specimen.particles.mass[i] = sphere_mass(body.radius, experiment.material.density);
    specimen.particles.inertial_mass[i] = specimen.particles.mass[i];
  }
  state.growth = next;
  specimen.contacts.valid = false;
  specimen.last_time_step = 0.0;
  dynamics.assess(specimen);
}

void finish(Specimen& specimen, PackingState& state, const Experiment& experiment, Dynamics& dynamics) {
  name_particles(specimen, experiment);
  specimen.clocks = Clocks{};
  specimen.crack_time = 0.0;
  specimen.initial_mass = particle_mass(specimen);
  specimen.initial_height = specimen.walls.length(2);
  specimen.initial_volume = specimen.walls.volume();
  dynamics.assess(specimen);
  const ElasticEnergy elastic = elastic_energy(specimen, dynamics.model());
  specimen.energy = EnergyLedger{};
  specimen.energy.initial_stored = elastic.normal + kinetic_energy(specimen);
  specimen.energy.initial_tangential = elastic.tangential;
  state.step = PackingState::Step::kDone;
}

/// After settling at full friction: another fall of friction if the specimen is still too loose.
bool fall_again(Specimen& specimen, PackingState& state, const Experiment& experiment) {
  const double target = experiment.specimen.void_ratio;
  const double e = void_ratio(specimen.walls, specimen.initial_mass / experiment.material.density);
  const bool densest = state.generation_friction == 0.0;
  if (e - target <= kCloseEnough || densest || ++state.falls >= kMostFalls) return false;
  // Settling took it from stop_void_ratio to e; expect the same again, but always go on by half the way at
  // least.
  const double settling = std::max(0.0, state.stop_void_ratio - e);
  state.stop_void_ratio = std::min(target + settling, 0.5 * (e + target));
  specimen.friction = state.generation_friction;
  start_step(state, PackingState::Step::kLowerFriction);
  return true;
}

}  // namespace

Specimen scatter(const Experiment& experiment) {
  const SpecimenSpec& spec = experiment.specimen;
  const std::int64_t count = spec.particles ? *spec.particles : count_for_side(experiment, *spec.side);
  const std::vector<double> diameters = stratified_diameters(spec.grading, count);
  double solid = 0.0;
  for (const double d : diameters) solid += std::numbers::pi / 6.0 * d * d * d;
  const double side = elementary::pow(solid * (1.0 + spec.void_ratio + kLooser), 1.0 / 3.0);
  Specimen specimen;
  for (std::size_t axis = 0; axis < 3; ++axis) specimen.walls.position[2 * axis + 1] = side;
  Scatter room(side, kFirstGrowth * diameters.back(), spec.seed);
  for (auto d = diameters.rbegin(); d != diameters.rend(); ++d) {
    Birth birth;
    birth.id = birth.parent = specimen.particles.size();
    birth.radius = 0.5 * kFirstGrowth * *d;
    const std::array<double, 3> centre = room.place(birth.id, birth.radius);
    std::copy(centre.begin(), centre.end(), birth.position);
    append_particle(specimen.particles, experiment, birth);
  }
  specimen.next_id = specimen.particles.size();
  specimen.friction = 0.0;
  specimen.initial_mass = solid * experiment.material.density;
  return specimen;
}

PackingFault pack_one_cycle(Specimen& specimen, PackingState& state, const Experiment& experiment,
                            Dynamics& dynamics) {
  using Step = PackingState::Step;
  const double stress = experiment.specimen.isotropic_stress;
  if (state.step == Step::kGrow) {
    if (state.growth == 0.0) {
      state.growth = kFirstGrowth;
      dynamics.assess(specimen);
    } else if (state.step_cycle % kGrowthCycles == 0) {
      grow(specimen, state, experiment, dynamics);
    }
  }
  dynamics.cycle(specimen, isotropic(experiment, state.step == Step::kGrow));
  const std::int64_t cycle = ++state.step_cycle;
  if (specimen.cycle % (10 * Dynamics::kMeasureInterval) == 1 && state.step != Step::kRestore) {
    stop_free_flight(specimen.particles);
  }
  const bool rough_target = on_target(specimen, stress, 0.1);
  switch (state.step) {
    case Step::kGrow:
      if (state.growth == 1.0 && cycle % kGrowthCycles == 0) {
        specimen.friction = kFirstFriction;
        start_step(state, Step::kCompress);
      }
      break;
    case Step::kCompress:
      if (!rough_target) state.quiet_since = cycle;
      if (cycle - state.quiet_since >= kQuietCycles) {
        state.stop_void_ratio = experiment.specimen.void_ratio + kFirstMargin;
        start_step(state, Step::kLowerFriction);
      }
      break;
    case Step::kLowerFriction: {
      // (1 - ln 2 / N) each cycle halves in N cycles.
      specimen.friction *= 1.0 - std::numbers::ln2 / static_cast<double>(kFrictionHalving);
      if (specimen.friction < kLeastFriction) specimen.friction = 0.0;
      const double e = void_ratio(specimen.walls, specimen.initial_mass / experiment.material.density);
      // At zero friction: wait until the void ratio no longer falls.
      if (specimen.friction > 0.0 || !rough_target || e < state.lowest_void_ratio - 1e-4) {
        state.quiet_since = cycle;
        state.lowest_void_ratio = e;
      }
      const bool densest = cycle - state.quiet_since >= 5 * kQuietCycles;
      if (e <= state.stop_void_ratio || densest) {
        state.generation_friction = specimen.friction;
        specimen.friction = experiment.material.friction;
        start_step(state, Step::kRestore);
      }
      break;
    }
    case Step::kRestore:
      if (!on_target(specimen, stress, experiment.numerics.settle_tolerance)) state.quiet_since = cycle;
      if (cycle - state.quiet_since >= kQuietCycles && specimen.unbalanced_force_ratio < kRestoreUnbalanced) {
        if (!fall_again(specimen, state, experiment)) finish(specimen, state, experiment, dynamics);
      }
      break;
    case Step::kDone:
      break;
  }
  if (state.step_cycle > kMostCycles) {
    return absl::StrCat("packing did not settle: unbalanced force ratio ", specimen.unbalanced_force_ratio,
                        ", stress ", specimen.walls.stress(0), " / ", specimen.walls.stress(1), " / ",
                        specimen.walls.stress(2), " Pa");
  }
  return {};
}

}  // namespace creep
