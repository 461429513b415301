// The contact kernel, several contacts at a time: contact_kernel_scalar.cpp operation by operation. (kernel)
//
// Read the scalar twin first; names are the same. Lanes that do not touch compute with overlap 0 and are
// masked.
//
// A block of contacts goes through four stages. One contact is a long chain of operations, each waiting for
// the one before (two square roots, two divisions, a table); a processor looks a few hundred operations
// ahead, so only short stages let the chains of several groups run side by side.
#pragma once

#include <numbers>

#include "core/dem/kernels.h"
#include "core/dem/lanes.h"
#include "core/dem/quad.h"

namespace creep::CREEP_KERNEL_NAMESPACE {

struct Lanes3 {
  Vec x, y, z;
};

inline Vec dot(const Lanes3& a, const Lanes3& b) { return fma(a.x, b.x, fma(a.y, b.y, a.z * b.z)); }
inline Lanes3 scaled(const Lanes3& a, Vec s) { return {a.x * s, a.y * s, a.z * s}; }
/// s a + b, fused.
inline Lanes3 fma3(Vec s, const Lanes3& a, const Lanes3& b) {
  return {fma(s, a.x, b.x), fma(s, a.y, b.y), fma(s, a.z, b.z)};
}

/// a x b
inline Lanes3 cross(const Lanes3& a, const Lanes3& b) {
  const Vec zero = all(0.0);
  return {fma(a.y, b.z, zero - a.z * b.y), fma(a.z, b.x, zero - a.x * b.z), fma(a.x, b.y, zero - a.y * b.x)};
}

/// r1 omega1 + r2 omega2 of contacts c, c+1, ...
inline Lanes3 rolling(const ContactPhase& phase, std::size_t c) {
  Vec a[8], b[8], p[4], q[4];
  load_bodies(phase.body, phase.first + c, a);
  load_bodies(phase.body, phase.second + c, b);
  load_quads(&phase.spin->x, load_indices(phase.first + c), p);
  load_quads(&phase.spin->x, load_indices(phase.second + c), q);
  return {fma(a[3], p[0], b[3] * q[0]), fma(a[3], p[1], b[3] * q[1]), fma(a[3], p[2], b[3] * q[2])};
}

template <bool kRough>
inline void evaluate(const LawView& law, Vec overlap, Vec& g, Vec& slope) {
  if constexpr (kRough) {
    const Vec scale = all(law.inverse_delta_T1);
    const Mask below_hertz = greater(all(law.delta_T2), overlap);
    const Vec u = keep(below_hertz, overlap * scale);              // Hertz lanes read cell 0
    const Mask in_cells = greater(u, all(0x1.fffffffffffffp-21));  // u >= 2^-20
    const Vec index = from_bits(shift_right(bits(u), law.cell_shift) - all_int(law.before_first_cell));
    const Int cell = bits(keep(in_cells, index));
    const Vec base = keep(in_cells, from_bits(bits(u) & all_int(law.base_mask)));
    Vec c[4];
    load_quads(law.cells, cell, c);
    const Vec x = u - base;
    const Vec p2 = fma(c[3], x, c[2]);
    const Vec p1 = fma(p2, x, c[1]);
    g = fma(p1, x, c[0]);
    slope = fma(fma(c[3], x, p2), x, p1) * scale;
    if (count(below_hertz) != kLanes) {
      const Vec depth = overlap - all(law.hertz_offset);
      const Vec root = sqrt(max(depth, all(0.0)));
      g = select(below_hertz, g, (all(4.0 / 3.0) * depth) * root);
      slope = select(below_hertz, slope, all(2.0) * root);
    }
  } else {
    const Vec root = sqrt(overlap);
    g = (all(4.0 / 3.0) * overlap) * root;
    slope = all(2.0) * root;
  }
}

/// Contacts that go through the stages together: what one stage leaves for the next stays in the first cache.
inline constexpr std::size_t kBlock = 64;

/// What the stages of a block hand on, a number a contact. Lanes that do not touch have overlap 0.
struct alignas(64) Block {
  double overlap[kBlock];                                       // [m]
  double normal_x[kBlock], normal_y[kBlock], normal_z[kBlock];  // from first to second
  double motion_x[kBlock], motion_y[kBlock], motion_z[kBlock];  // of second over first in the last drift [m]
  double breaking_stress[kBlock];                               // the smaller one, times pi [Pa]
  double g[kBlock], slope[kBlock];                              // of the law
  ContactForce force[kBlock];                                   // on first
  double stress[kBlock];                                        // measuring cycles only [Pa]
};

/// Stage 1: where the particles of each pair are to one another.
template <bool kTurning>
inline void meet(const ContactPhase& phase, std::size_t c, std::size_t end, Block& block) {
  const Vec drift = all(phase.drift);
  for (std::size_t k = 0; c + k < end && k < kBlock; k += kLanes) {
    Vec pair[8];
    load_pairs(phase.body, phase.first + c + k, phase.second + c + k, pair);
    const Lanes3 d{pair[0], pair[1], pair[2]};
    const Vec distance = sqrt(dot(d, d));
    const Vec overlap = pair[3] - distance;
    Mask touching = greater(overlap, all(0.0));
    if (c + k + kLanes > end) touching = both(touching, first_lanes(static_cast<int>(end - c - k)));
    store(block.overlap + k, keep(touching, overlap));
    const Lanes3 n = scaled(d, all(1.0) / distance);
    store(block.normal_x + k, n.x);
    store(block.normal_y + k, n.y);
    store(block.normal_z + k, n.z);
    Lanes3 v{pair[4], pair[5], pair[6]};
    if constexpr (kTurning) {
      const Lanes3 lag = cross(rolling(phase, c + k), n);
      v = {v.x - lag.x, v.y - lag.y, v.z - lag.z};
    }
    store(block.motion_x + k, v.x * drift);
    store(block.motion_y + k, v.y * drift);
    store(block.motion_z + k, v.z * drift);
    store(block.breaking_stress + k, pair[7]);
  }
}

/// Stage 2: the law.
template <bool kRough>
inline void press(const ContactPhase& phase, std::size_t size, Block& block) {
  for (std::size_t k = 0; k < size; k += kLanes) {
    Vec g, slope;
    evaluate<kRough>(phase.law, load(block.overlap + k), g, slope);
    store(block.g + k, g);
    store(block.slope + k, slope);
  }
}

/// What a share adds up, lane by lane.
struct Totals {
  Int tangential_work = all_int(0), friction = all_int(0), force = all_int(0), overlap = all_int(0);
  Vec largest_ratio = all(0.0);
  std::int64_t touching = 0;
  bool breaking = false;
};

/// What only measuring cycles look at: sums for the guards.
inline void measure(const ContactPhase& phase, std::size_t c, Mask touching, Vec overlap, const Lanes3& f,
                    Totals& totals) {
  totals.force = totals.force + to_quanta(touching, sqrt(dot(f, f)), 0x1p40);
  totals.overlap = totals.overlap + to_quanta(touching, overlap, 0x1p60);
  totals.touching += count(touching);
  const Vec smaller = min(load_radii(phase.body, phase.first + c), load_radii(phase.body, phase.second + c));
  totals.largest_ratio = max(totals.largest_ratio, keep(touching, overlap / smaller));
}

/// Stage 3: friction, the force of the contact, whether it breaks a particle.
template <bool kTurning, bool kMeasure, bool kCheck>
inline void rub(const ContactPhase& phase, std::size_t begin, std::size_t size, Block& block,
                Totals& totals) {
  const Vec zero = all(0.0);
  for (std::size_t k = 0; k < size; k += kLanes) {
    const std::size_t c = begin + k;
    const Vec overlap = load(block.overlap + k);
    const Mask touching = greater(overlap, zero);
    const Lanes3 n{load(block.normal_x + k), load(block.normal_y + k), load(block.normal_z + k)};
    const Lanes3 u{load(block.motion_x + k), load(block.motion_y + k), load(block.motion_z + k)};
    const Vec root_radius = load(phase.root_radius + c);
    const Vec prefactor = all(phase.modulus) * root_radius;
    const Vec fn = prefactor * load(block.g + k);
    const Vec kn = prefactor * load(block.slope + k);
    const Vec kt = all(phase.tangential_ratio) * kn;

    const Lanes3 s = fma3(zero - dot(u, n), n, u);
    const Lanes3 old{load(phase.shear_x + c), load(phase.shear_y + c), load(phase.shear_z + c)};
    const Lanes3 trial = fma3(kt, s, fma3(zero - dot(old, n), n, old));
    const Vec squared = dot(trial, trial);
    const Vec cap = all(phase.friction) * fn;
    Lanes3 t = trial;
    const Mask sliding = both(touching, greater(squared, cap * cap));
    if (any(sliding)) {
      const Vec magnitude = sqrt(squared);
      const Vec scale = cap / magnitude;
      t = {select(sliding, trial.x * scale, trial.x), select(sliding, trial.y * scale, trial.y),
           select(sliding, trial.z * scale, trial.z)};
      totals.friction = totals.friction + to_quanta(sliding, (magnitude - cap) * cap / kt, 0x1p70);
    }
    const Lanes3 mean{old.x + t.x, old.y + t.y, old.z + t.z};
    totals.tangential_work = totals.tangential_work + to_quanta(touching, all(0.5) * dot(mean, s), 0x1p70);
    store(phase.shear_x + c, keep(touching, t.x));
    store(phase.shear_y + c, keep(touching, t.y));
    store(phase.shear_z + c, keep(touching, t.z));
    if constexpr (kTurning) {
      const Lanes3 couple = cross(n, t);
      store_forces(phase.couple + c, keep(touching, couple.x), keep(touching, couple.y),
                   keep(touching, couple.z), zero);
    }
    const Lanes3 f = fma3(zero - fn, n, t);
    store_forces(block.force + k, keep(touching, f.x), keep(touching, f.y), keep(touching, f.z),
                 kMeasure ? keep(touching, kn) : zero);

    const Vec area = root_radius * root_radius * overlap;
    if constexpr (kCheck) {
      totals.breaking =
          totals.breaking || any(both(touching, greater(fn, load(block.breaking_stress + k) * area)));
    }
    if constexpr (kMeasure) {
      store(block.stress + k, keep(touching, fn / (all(std::numbers::pi) * area)));
      measure(phase, c, touching, overlap, f, totals);
    }
  }
}

inline void raise(double& largest, double value) { largest = value > largest ? value : largest; }

/// The sum of the particle that is first at present: contacts of one first follow one another.
struct Running {
  std::int32_t first = -1;  // -1: none
  Quad sum = quad_all(0.0);
};

/// The forces of contacts c, c+1, ... one by one: those of deferred ends go to slots.
template <bool kMeasure>
inline void add_apart(const ContactPhase& phase, std::size_t c, std::size_t end, const ContactForce* force,
                      const double* stress) {
  double* const resultant = &phase.resultant->x;
  for (; c < end; ++c, ++force, ++stress) {
    const Quad f = load_quad(&force->x);
    const std::int32_t first = phase.first[c], second = phase.second[c];
    if (phase.deferred[c] != 0) {
      store_quad(&phase.force[c].x, f);
      if constexpr (kMeasure) phase.stress[c] = *stress;
    }
    const auto add = [&](std::int32_t particle, Quad on_it) {
      double* const sum = resultant + 4 * static_cast<std::ptrdiff_t>(particle);
      store_quad(sum, load_quad(sum) + on_it);
      if constexpr (kMeasure) raise(phase.peak_stress[particle], *stress);
    };
    if ((phase.deferred[c] & kDeferFirst) == 0) add(first, f);
    if ((phase.deferred[c] & kDeferSecond) == 0) add(second, turned(f));
  }
}

/// Stage 4: adds the forces to their particles, contact by contact. The sum of the first stays in a register:
/// through memory each addition would wait for the one before to be stored and read again. Nothing else
/// changes it meanwhile, since a second is never the first of its own contacts.
template <bool kMeasure>
inline void add_up(const ContactPhase& phase, std::size_t begin, std::size_t size, const Block& block,
                   Running& running) {
  double* const resultant = &phase.resultant->x;
  const std::int32_t* const first = phase.first + begin;
  const std::int32_t* const second = phase.second + begin;
  alignas(32) static constexpr double kNothing[4] = {0.0, 0.0, 0.0, 0.0};
  // The compiler must not see what is there: it would branch around the load instead of choosing an address,
  // and where one first ends and the next begins cannot be foreseen.
  const double* nothing = kNothing;
  asm("" : "+r"(nothing));
  std::int32_t before = running.first;
  Quad sum = running.sum;
  for (std::size_t k = 0; k < size; k += kKernelGrain) {
    std::uint64_t deferred = 0;
    __builtin_memcpy(&deferred, phase.deferred + begin + k, kKernelGrain);
    if (deferred != 0) {
      const std::size_t end = size - k < kKernelGrain ? size : k + kKernelGrain;
      add_apart<kMeasure>(phase, begin + k, begin + end, block.force + k, block.stress + k);
      before = -1;
      continue;
    }
#pragma GCC unroll 8
    for (std::size_t lane = k; lane < k + kKernelGrain; ++lane) {
      const Quad f = load_quad(&block.force[lane].x);
      const std::int32_t now = first[lane];
      double* const of_first = resultant + 4 * static_cast<std::ptrdiff_t>(now);
      double* const of_second = resultant + 4 * static_cast<std::ptrdiff_t>(second[lane]);
      sum = one_of_plus(now == before, sum, load_quad(now == before ? nothing : of_first), f);
      before = now;
      store_quad(of_first, sum);
      store_quad(of_second, load_quad(of_second) + turned(f));
      if constexpr (kMeasure) {
        raise(phase.peak_stress[now], block.stress[lane]);
        raise(phase.peak_stress[second[lane]], block.stress[lane]);
      }
    }
  }
  running = {before, sum};
}

/// How many contacts ahead the memory is asked for, about two microseconds.
inline constexpr std::size_t kAhead = 256;

/// Asks for the second particles of a block to come: their places jump, which the processor cannot foresee.
inline void ask_ahead(const ContactPhase& phase, std::size_t c, std::size_t end) {
  const std::size_t begin = c + kAhead;
  for (std::size_t k = begin; k < begin + kBlock && k < end; ++k) {
    __builtin_prefetch(phase.body + phase.second[k]);
    __builtin_prefetch(phase.resultant + phase.second[k], 1);
  }
}

template <bool kTurning, bool kRough, bool kMeasure, bool kCheck>
void contacts_of(const ContactPhase& phase, std::size_t begin, std::size_t end, ContactSums& sums) {
  Totals totals;
  Running running;
  Block block;
  for (std::size_t c = begin; c < end; c += kBlock) {
    const std::size_t size = end - c < kBlock ? end - c : kBlock;
    if (phase.ask_ahead) ask_ahead(phase, c, end);
    meet<kTurning>(phase, c, end, block);
    press<kRough>(phase, size, block);
    rub<kTurning, kMeasure, kCheck>(phase, c, size, block, totals);
    add_up<kMeasure>(phase, c, size, block, running);
  }
  sums.tangential_work += sum(totals.tangential_work);
  sums.friction += sum(totals.friction);
  sums.breaking = sums.breaking || totals.breaking;
  if constexpr (kMeasure) {
    sums.force += sum(totals.force);
    sums.overlap += sum(totals.overlap);
    sums.touching += totals.touching;
    alignas(64) double ratio[kLanes];
    store(ratio, totals.largest_ratio);
    for (const double r : ratio)
      sums.largest_overlap_ratio = r > sums.largest_overlap_ratio ? r : sums.largest_overlap_ratio;
  }
}

template <bool kTurning, bool kRough>
void contacts_with_law(const ContactPhase& phase, CycleKind kind, std::size_t begin, std::size_t end,
                       ContactSums& sums) {
  if (kind.measure) {
    kind.check ? contacts_of<kTurning, kRough, true, true>(phase, begin, end, sums)
               : contacts_of<kTurning, kRough, true, false>(phase, begin, end, sums);
  } else {
    kind.check ? contacts_of<kTurning, kRough, false, true>(phase, begin, end, sums)
               : contacts_of<kTurning, kRough, false, false>(phase, begin, end, sums);
  }
}

inline void contacts(const ContactPhase& phase, CycleKind kind, std::size_t begin, std::size_t end,
                     ContactSums& sums) {
  const bool rough = phase.law.cells != nullptr;
  if (phase.spin == nullptr) {
    rough ? contacts_with_law<false, true>(phase, kind, begin, end, sums)
          : contacts_with_law<false, false>(phase, kind, begin, end, sums);
  } else {
    rough ? contacts_with_law<true, true>(phase, kind, begin, end, sums)
          : contacts_with_law<true, false>(phase, kind, begin, end, sums);
  }
}

}  // namespace creep::CREEP_KERNEL_NAMESPACE
