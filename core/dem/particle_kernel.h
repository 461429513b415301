// The particle kernel: wall contacts, resultant, local damping, kick and drift of each particle. (kernel)
//
// Plain scalar code that every kernel source includes and compiles for its own instruction set. It fuses
// nothing but the law's polynomial, so it gives the same bits in each. The resultant is summed in ascending
// neighbour id: walls, then neighbours of lower id (they own the contact, so the force is subtracted), then
// those of higher id.
#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "core/dem/kernels.h"
#include "core/dem/quad.h"

namespace creep::CREEP_KERNEL_NAMESPACE {

namespace particle {

inline void evaluate(const LawView& law, double overlap, double& g, double& slope) {
  if (law.cells == nullptr || overlap >= law.delta_T2) {
    const double depth = overlap - law.hertz_offset;
    const double root = __builtin_sqrt(depth);
    g = ((4.0 / 3.0) * depth) * root;
    slope = 2.0 * root;
    return;
  }
  const double u = overlap * law.inverse_delta_T1;
  const auto bits = std::bit_cast<std::uint64_t>(u);
  std::int64_t cell = static_cast<std::int64_t>(bits >> law.cell_shift) - law.before_first_cell;
  double base = std::bit_cast<double>(bits & static_cast<std::uint64_t>(law.base_mask));
  if (u < 0x1p-20) {
    cell = 0;
    base = 0.0;
  }
  const double* c = law.cells + 4 * cell;
  const double x = u - base;
  const double p2 = __builtin_fma(c[3], x, c[2]);
  const double p1 = __builtin_fma(p2, x, c[1]);
  g = __builtin_fma(p1, x, c[0]);
  slope = __builtin_fma(__builtin_fma(c[3], x, p2), x, p1) * law.inverse_delta_T1;
}

inline std::int64_t to_quanta(double value, double scale) {
  double clamped = value * scale;
  clamped = clamped > -quanta::kLimit ? clamped : -quanta::kLimit;
  clamped = clamped < quanta::kLimit ? clamped : quanta::kLimit;
  return std::bit_cast<std::int64_t>(clamped + quanta::kMagic) - std::bit_cast<std::int64_t>(quanta::kMagic);
}

struct WallLoad {
  // As a vector from the start: one read back from numbers just written waits until they have left for the
  // cache.
  Quad force_and_stiffness = quad_all(0.0);
  double stress = 0.0;    // largest F/(pi R delta)
  double breaking = 0.0;  // largest stress ratio above 1, else 0
};

/// Contact of a particle with one wall.
struct AtWall {
  unsigned axis;
  double side;  // 1 at the high wall, -1 at the low one
  double force, stiffness;
};

/// Coulomb friction of particle i at a wall, which moves along its axis alone: from the force before the last
/// drift, `old`, to that of now. The contact kernel's steps, with the wall as the second body.
inline void rub(const ParticlePhase& phase, std::size_t i, const AtWall& at, const double (&old)[2],
                WallLoad& load, ParticleSums& sums) {
  const Body& body = phase.body[i];
  const unsigned b = (at.axis + 1) % 3, c = (at.axis + 2) % 3;
  const double velocity[3] = {body.vx, body.vy, body.vz};
  double ub = velocity[b], uc = velocity[c];
  if (phase.spin != nullptr) {
    const double spin[3] = {phase.spin[i].x, phase.spin[i].y, phase.spin[i].z};
    const double arm = at.side * body.radius;
    ub = ub + arm * spin[c];
    uc = uc - arm * spin[b];
  }
  const double kt = phase.tangential_ratio * at.stiffness;
  const double sb = (0.0 - ub) * phase.last_drift, sc = (0.0 - uc) * phase.last_drift;
  double tb = old[0] + kt * sb, tc = old[1] + kt * sc;
  const double squared = tb * tb + tc * tc;
  const double cap = phase.wall_friction * at.force;
  if (squared > cap * cap) {
    const double trial = __builtin_sqrt(squared);
    const double scale = cap / trial;
    tb = tb * scale;
    tc = tc * scale;
    sums.friction += to_quanta((trial - cap) * cap / kt, 0x1p70);
  }
  sums.tangential_work += to_quanta(0.5 * ((old[0] + tb) * sb + (old[1] + tc) * sc), 0x1p70);
  phase.wall_shear[i].across[at.axis][0] = tb;
  phase.wall_shear[i].across[at.axis][1] = tc;
  load.force_and_stiffness = load.force_and_stiffness + in_lane(b, tb) + in_lane(c, tc);
}

/// Contacts of particle i with the walls near it, r' = R.
template <bool kRubs>
inline WallLoad wall_contacts(const ParticlePhase& phase, std::size_t i, CycleKind kind, ParticleSums& sums) {
  const Body& body = phase.body[i];
  unsigned near = phase.near_walls[i];
  WallLoad load;
  [[maybe_unused]] WallShear old;
  if constexpr (kRubs) old = std::exchange(phase.wall_shear[i], WallShear{});
  const double centre[3] = {body.x, body.y, body.z};
  for (; near != 0; near &= near - 1) {
    const auto wall = static_cast<unsigned>(std::countr_zero(near));
    const unsigned axis = wall / 2;
    const bool high = (wall & 1u) != 0;
    const double gap =
        high ? phase.wall_position[wall] - centre[axis] : centre[axis] - phase.wall_position[wall];
    const double overlap = body.radius - gap;
    if (!(overlap > 0.0)) continue;
    double g, slope;
    evaluate(phase.law, overlap, g, slope);
    const double prefactor = phase.wall_modulus * __builtin_sqrt(body.radius);
    const double force = prefactor * g, stiffness = prefactor * slope;
    load.force_and_stiffness =
        load.force_and_stiffness + three_and_one(in_lane(axis, high ? -force : force), quad_all(stiffness));
    sums.wall_force[wall] += to_quanta(force, 0x1p40);
    sums.wall_stiffness[wall] += to_quanta(stiffness, 0x1p20);
    if constexpr (kRubs)
      rub(phase, i, {axis, high ? 1.0 : -1.0, force, stiffness}, old.across[axis], load, sums);
    const double area = body.radius * overlap;
    if (kind.check && force > body.breaking_stress * area) {
      const double ratio = force / (body.breaking_stress * area);
      load.breaking = ratio > load.breaking ? ratio : load.breaking;
    }
    if (kind.measure) {
      const double stress = force / (std::numbers::pi * area);
      load.stress = stress > load.stress ? stress : load.stress;
    }
  }
  return load;
}

/// Moves a particle under its resultant; lane 3 of position and velocity holds other fields and stays.
/// Returns the work of local damping [J].
inline double move(const ParticlePhase& phase, Quad force, double mass, Quad& position, Quad& velocity) {
  const Quad zero = quad_all(0.0);
  const Quad before = three_and_one(velocity, zero);
  const Quad damping = with_sign(quad_all(phase.local_damping) * force, before);
  const Quad after = before + (force - damping) * quad_all(phase.kick / mass);
  velocity = three_and_one(after, velocity);
  position = three_and_one(position + three_and_one(after, zero) * quad_all(phase.drift), position);
  alignas(32) double power[4];
  store_quad(power, damping * (quad_all(0.5) * (before + after)));
  return (power[0] + power[1] + power[2]) * phase.kick;
}

}  // namespace particle

/// What only some particles have: contacts of several threads, whose slots are added up here, and walls.
template <bool kMeasure, bool kRubs>
void complete(const ParticlePhase& phase, CycleKind kind, std::size_t i, ParticleSums& sums) {
  using namespace particle;
  Quad force = load_quad(&phase.resultant[i].x);
  double stress = kMeasure ? phase.peak_stress[i] : 0.0;
  if (phase.shared[i] != 0) {
    force = quad_all(0.0);
    const auto add = [&](std::int32_t c, Quad sum) {
      force = sum;
      if constexpr (kMeasure) stress = phase.stress[c] > stress ? phase.stress[c] : stress;
    };
    for (std::int32_t k = phase.lower_begin[i]; k < phase.lower_begin[i + 1]; ++k) {
      const std::int32_t c = phase.lower_contact[k];
      add(c, force + turned(load_quad(&phase.force[c].x)));
    }
    for (std::int32_t c = phase.own_begin[i]; c < phase.own_begin[i + 1]; ++c)
      add(c, force + load_quad(&phase.force[c].x));
  }
  if (phase.near_walls[i] != 0) {
    const WallLoad load = wall_contacts<kRubs>(phase, i, kind, sums);
    force = force + load.force_and_stiffness;
    stress = load.stress > stress ? load.stress : stress;
    if (load.breaking > 0.0) {
      sums.breaking = true;
      phase.breaking[i] = load.breaking;
    }
  }
  store_quad(&phase.resultant[i].x, force);
  if constexpr (kMeasure) phase.peak_stress[i] = stress;
}

template <bool kMeasure, bool kRubs>
void complete_each(const ParticlePhase& phase, CycleKind kind, std::size_t begin, std::size_t end,
                   ParticleSums& sums) {
  const std::int32_t* const last = phase.special + phase.special_count;
  const std::int32_t* i = std::lower_bound(phase.special, last, static_cast<std::int32_t>(begin));
  for (; i != last && static_cast<std::size_t>(*i) < end; ++i)
    complete<kMeasure, kRubs>(phase, kind, static_cast<std::size_t>(*i), sums);
}

/// Before any of them moves: a loop of its own is one whose turns the processor can foresee.
template <bool kMeasure>
void complete_special(const ParticlePhase& phase, CycleKind kind, std::size_t begin, std::size_t end,
                      ParticleSums& sums) {
  phase.wall_shear != nullptr ? complete_each<kMeasure, true>(phase, kind, begin, end, sums)
                              : complete_each<kMeasure, false>(phase, kind, begin, end, sums);
}

template <bool kMeasure, bool kMove>
void particles_of(const ParticlePhase& phase, CycleKind kind, std::size_t begin, std::size_t end,
                  ParticleSums& sums) {
  using namespace particle;
  complete_special<kMeasure>(phase, kind, begin, end, sums);
  bool list_ends = false;
  std::int64_t damping = 0;
  double stiffest = sums.largest_stiffness_over_mass;
  for (std::size_t i = begin; i < end; ++i) {
    Body& body = phase.body[i];
    const Quad force = load_quad(&phase.resultant[i].x);
    store_quad(&phase.resultant[i].x, quad_all(0.0));
    const double mass = phase.inertial_mass[i];
    if constexpr (kMeasure) {
      alignas(32) double f[4];
      store_quad(f, force);
      const double stiffness = f[3];
      phase.mobilised_stress[i] = phase.peak_stress[i];
      phase.peak_stress[i] = 0.0;
      if (stiffness > 0.0) {
        ++sums.with_contacts;
        sums.resultant += to_quanta(__builtin_sqrt(f[0] * f[0] + f[1] * f[1] + f[2] * f[2]), 0x1p40);
      }
      const double floor = phase.floor_stiffness * __builtin_sqrt(body.radius);
      const double ratio = (stiffness > floor ? stiffness : floor) / mass;
      stiffest = ratio > stiffest ? ratio : stiffest;
      const double all_of_it = f[0] + f[1] + f[2] + body.x + body.y + body.z + body.vx + body.vy + body.vz;
      if (!(all_of_it - all_of_it == 0.0)) sums.finite = false;
    }
    if constexpr (kMove) {
      Quad position = load_quad(&body.x), velocity = load_quad(&body.vx);
      damping +=
          to_quanta(move(phase, three_and_one(force, quad_all(0.0)), mass, position, velocity), 0x1p70);
      store_quad(&body.x, position);
      store_quad(&body.vx, velocity);
      alignas(32) double away[4];
      const Quad d = position - load_quad(&phase.reference[i].x);
      store_quad(away, d * d);
      list_ends = list_ends || away[0] + away[1] + away[2] > phase.reference[i].reach_squared;
    }
  }
  sums.list_ends = sums.list_ends || list_ends;
  sums.damping += damping;
  sums.largest_stiffness_over_mass = stiffest;
}

inline void particles(const ParticlePhase& phase, CycleKind kind, std::size_t begin, std::size_t end,
                      ParticleSums& sums) {
  if (kind.measure) {
    kind.move ? particles_of<true, true>(phase, kind, begin, end, sums)
              : particles_of<true, false>(phase, kind, begin, end, sums);
  } else {
    kind.move ? particles_of<false, true>(phase, kind, begin, end, sums)
              : particles_of<false, false>(phase, kind, begin, end, sums);
  }
}

}  // namespace creep::CREEP_KERNEL_NAMESPACE
