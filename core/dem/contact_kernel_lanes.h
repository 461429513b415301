// The contact kernel, several contacts at a time: contact_kernel_scalar.cpp operation by operation. (kernel)
//
// Read the scalar twin first; names are the same. Lanes that do not touch compute with overlap 0 and are
// masked.
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

/// Rounded to integers by the exponent trick; lanes outside the mask count nothing.
inline Int to_quanta(Mask mask, Vec value, double scale) {
  const Vec clamped = min(max(value * all(scale), all(-quanta::kLimit)), all(quanta::kLimit));
  return bits(keep(mask, clamped) + all(quanta::kMagic)) - bits(all(quanta::kMagic));
}

/// Adds the forces of contacts c, c+1, ... to their particles, in this order, but for deferred ends.
inline void scatter(const ContactPhase& phase, std::size_t c, const ContactForce* force) {
  double* const resultant = &phase.resultant->x;
  std::uint64_t deferred = 0;
  __builtin_memcpy(&deferred, phase.deferred + c, kLanes);
  if (deferred == 0) {
#pragma GCC unroll 8
    for (int k = 0; k < kLanes; ++k) {
      const Quad f = load_quad(&force[k].x);
      double* const first =
          resultant + 4 * static_cast<std::ptrdiff_t>(phase.first[c + static_cast<std::size_t>(k)]);
      double* const second =
          resultant + 4 * static_cast<std::ptrdiff_t>(phase.second[c + static_cast<std::size_t>(k)]);
      store_quad(first, load_quad(first) + f);
      store_quad(second, load_quad(second) - f);
    }
    return;
  }
  for (int k = 0; k < kLanes; ++k) {
    const std::size_t at = c + static_cast<std::size_t>(k);
    const Quad f = load_quad(&force[k].x);
    double* const first = resultant + 4 * static_cast<std::ptrdiff_t>(phase.first[at]);
    double* const second = resultant + 4 * static_cast<std::ptrdiff_t>(phase.second[at]);
    if (phase.deferred[at] != 0) store_quad(&phase.force[at].x, f);
    if ((phase.deferred[at] & kDeferFirst) == 0) store_quad(first, load_quad(first) + f);
    if ((phase.deferred[at] & kDeferSecond) == 0) store_quad(second, load_quad(second) - f);
  }
}

/// Measuring cycles store forces in their slots, others leave them for the scatter of the next iteration.
template <bool kMeasure>
inline void hand_over(const ContactPhase& phase, std::size_t c, const Lanes3& f, Vec stiffness,
                      ContactForce* pending) {
  if constexpr (kMeasure) {
    store_forces(phase.force + c, f.x, f.y, f.z, stiffness);
  } else {
    store_forces(pending, f.x, f.y, f.z, all(0.0));
  }
}

template <bool kTurning, bool kRough, bool kMeasure, bool kCheck>
void contacts_of(const ContactPhase& phase, std::size_t begin, std::size_t end, ContactSums& sums) {
  const Vec zero = all(0.0);
  Int tangential_work = all_int(0), friction = all_int(0), force_sum = all_int(0), overlap_sum = all_int(0);
  Vec largest_ratio = zero;
  bool breaking = false;
  alignas(64) ContactForce pending[kLanes];
  for (std::size_t c = begin; c < end; c += kLanes) {
    Vec pair[8];
    load_pairs(phase.body, phase.first + c, phase.second + c, pair);
    const Lanes3 d{pair[0], pair[1], pair[2]};
    const Vec distance = sqrt(dot(d, d));
    if constexpr (!kMeasure) {
      // The sums run through memory, one after the other: done here, they fill the wait for the square root.
      if (c != begin) scatter(phase, c - kLanes, pending);
    }
    const Vec reach = pair[3];
    const Vec gap_overlap = reach - distance;
    Mask touching = greater(gap_overlap, zero);
    if (c + kLanes > end) touching = both(touching, first_lanes(static_cast<int>(end - c)));
    if (!any(touching)) {
      store(phase.shear_x + c, zero);
      store(phase.shear_y + c, zero);
      store(phase.shear_z + c, zero);
      if constexpr (kTurning) store_forces(phase.couple + c, zero, zero, zero, zero);
      hand_over<kMeasure>(phase, c, {zero, zero, zero}, zero, pending);
      if constexpr (kMeasure) store(phase.stress + c, zero);
      continue;
    }
    const Vec overlap = keep(touching, gap_overlap);
    const Lanes3 n = scaled(d, all(1.0) / distance);
    Vec g, slope;
    evaluate<kRough>(phase.law, overlap, g, slope);
    const Vec root_radius = load(phase.root_radius + c);
    const Vec prefactor = all(phase.modulus) * root_radius;
    const Vec fn = prefactor * g;
    const Vec kn = prefactor * slope;
    const Vec kt = all(phase.tangential_ratio) * kn;

    const Vec drift = all(phase.drift);
    Lanes3 v{pair[4], pair[5], pair[6]};
    if constexpr (kTurning) {
      const Lanes3 lag = cross(rolling(phase, c), n);
      v = {v.x - lag.x, v.y - lag.y, v.z - lag.z};
    }
    const Lanes3 u = scaled(v, drift);
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
      friction = friction + to_quanta(sliding, (magnitude - cap) * cap / kt, 0x1p70);
    }
    const Lanes3 mean{old.x + t.x, old.y + t.y, old.z + t.z};
    tangential_work = tangential_work + to_quanta(touching, all(0.5) * dot(mean, s), 0x1p70);
    store(phase.shear_x + c, keep(touching, t.x));
    store(phase.shear_y + c, keep(touching, t.y));
    store(phase.shear_z + c, keep(touching, t.z));
    if constexpr (kTurning) {
      const Lanes3 couple = cross(n, t);
      store_forces(phase.couple + c, keep(touching, couple.x), keep(touching, couple.y),
                   keep(touching, couple.z), zero);
    }
    const Lanes3 f = fma3(zero - fn, n, t);
    hand_over<kMeasure>(phase, c, {keep(touching, f.x), keep(touching, f.y), keep(touching, f.z)},
                        keep(touching, kn), pending);

    const Vec area = root_radius * root_radius * overlap;
    if constexpr (kCheck) {
      breaking = breaking || any(both(touching, greater(fn, pair[7] * area)));
    }
    if constexpr (kMeasure) {
      store(phase.stress + c, keep(touching, fn / (all(std::numbers::pi) * area)));
      force_sum = force_sum + to_quanta(touching, sqrt(dot(f, f)), 0x1p40);
      overlap_sum = overlap_sum + to_quanta(touching, overlap, 0x1p60);
      sums.touching += count(touching);
      Vec a[8], b[8];
      load_bodies(phase.body, phase.first + c, a);
      load_bodies(phase.body, phase.second + c, b);
      largest_ratio = max(largest_ratio, keep(touching, overlap / min(a[3], b[3])));
    }
  }
  if constexpr (!kMeasure) {
    if (begin < end) scatter(phase, begin + (end - begin - 1) / kLanes * kLanes, pending);
  }
  sums.tangential_work += sum(tangential_work);
  sums.friction += sum(friction);
  sums.breaking = sums.breaking || breaking;
  if constexpr (kMeasure) {
    sums.force += sum(force_sum);
    sums.overlap += sum(overlap_sum);
    alignas(64) double ratio[kLanes];
    store(ratio, largest_ratio);
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
