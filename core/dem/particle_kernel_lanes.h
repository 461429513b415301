// The particle kernel, several particles at a time: particle_kernel.h operation by operation. (kernel)
//
// Read the plain one first; it does the last few particles of a share, and cycles that do not move. What only
// some particles have is completed before.
#pragma once

#include "core/dem/kernels.h"
#include "core/dem/lanes.h"
#include "core/dem/particle_kernel.h"

namespace creep::CREEP_KERNEL_NAMESPACE {

/// What groups of particles add up, lane by lane.
struct Moved {
  Int damping = all_int(0), resultant = all_int(0);
  Vec stiffest = all(0.0);
  std::int64_t with_contacts = 0;
  bool list_ends = false, finite = true;
};

/// One component of a group: kicks `velocity`, drifts `position`. Returns the power of local damping [W].
inline Vec move_along(const ParticlePhase& phase, Vec force, Vec kick_over_mass, Vec& position,
                      Vec& velocity) {
  const Vec before = velocity;
  const Vec damping = with_sign(all(phase.local_damping) * force, before);
  velocity = before + (force - damping) * kick_over_mass;
  position = position + velocity * all(phase.drift);
  return damping * (all(0.5) * (before + velocity));
}

/// `field` as load_consecutive_bodies gives it.
inline void measure_group(const ParticlePhase& phase, std::size_t i, const Vec force[4], const Vec field[8],
                          Vec mass, Moved& moved) {
  store_anywhere(phase.mobilised_stress + i, load_anywhere(phase.peak_stress + i));
  store_anywhere(phase.peak_stress + i, all(0.0));
  const Vec stiffness = force[3];
  const Mask touching = greater(stiffness, all(0.0));
  moved.with_contacts += count(touching);
  const Vec squared = force[0] * force[0] + force[1] * force[1] + force[2] * force[2];
  moved.resultant = moved.resultant + to_quanta(touching, sqrt(squared), 0x1p40);
  const Vec floor = all(phase.floor_stiffness) * sqrt(field[3]);
  moved.stiffest = max(max(stiffness, floor) / mass, moved.stiffest);
  const Vec all_of_it =
      force[0] + force[1] + force[2] + field[0] + field[1] + field[2] + field[4] + field[5] + field[6];
  moved.finite = moved.finite && count(equal(all_of_it - all_of_it, all(0.0))) == kLanes;
}

template <bool kMeasure>
inline void move_group(const ParticlePhase& phase, std::size_t i, Moved& moved) {
  Vec force[4], field[8], reference[4];
  load_consecutive_quads(&phase.resultant[i].x, force);
  for (std::size_t k = 0; k < kLanes; ++k) store_quad(&phase.resultant[i + k].x, quad_all(0.0));
  load_consecutive_bodies(phase.body + i, field);
  const Vec mass = load_anywhere(phase.inertial_mass + i);
  if constexpr (kMeasure) measure_group(phase, i, force, field, mass, moved);
  const Vec kick_over_mass = all(phase.kick) / mass;
  const Vec power_x = move_along(phase, force[0], kick_over_mass, field[0], field[4]);
  const Vec power_y = move_along(phase, force[1], kick_over_mass, field[1], field[5]);
  const Vec power_z = move_along(phase, force[2], kick_over_mass, field[2], field[6]);
  const Vec work = (power_x + power_y + power_z) * all(phase.kick);
  moved.damping = moved.damping + to_quanta(first_lanes(kLanes), work, 0x1p70);
  store_consecutive_bodies(phase.body + i, field);
  load_consecutive_quads(&phase.reference[i].x, reference);
  const Vec dx = field[0] - reference[0], dy = field[1] - reference[1], dz = field[2] - reference[2];
  moved.list_ends = moved.list_ends || any(greater(dx * dx + dy * dy + dz * dz, reference[3]));
}

template <bool kMeasure>
void move_particles(const ParticlePhase& phase, CycleKind kind, std::size_t begin, std::size_t end,
                    ParticleSums& sums) {
  Moved moved;
  std::size_t i = begin;
  complete_special<kMeasure>(phase, kind, begin, begin + (end - begin) / kLanes * kLanes, sums);
  for (; i + kLanes <= end; i += kLanes) move_group<kMeasure>(phase, i, moved);
  sums.damping += sum(moved.damping);
  sums.list_ends = sums.list_ends || moved.list_ends;
  if constexpr (kMeasure) {
    sums.resultant += sum(moved.resultant);
    sums.with_contacts += moved.with_contacts;
    sums.finite = sums.finite && moved.finite;
    alignas(64) double ratio[kLanes];
    store(ratio, moved.stiffest);
    for (const double r : ratio)
      sums.largest_stiffness_over_mass =
          r > sums.largest_stiffness_over_mass ? r : sums.largest_stiffness_over_mass;
  }
  particles(phase, kind, i, end, sums);
}

inline void particles_in_lanes(const ParticlePhase& phase, CycleKind kind, std::size_t begin, std::size_t end,
                               ParticleSums& sums) {
  if (!kind.move) return particles(phase, kind, begin, end, sums);
  kind.measure ? move_particles<true>(phase, kind, begin, end, sums)
               : move_particles<false>(phase, kind, begin, end, sums);
}

}  // namespace creep::CREEP_KERNEL_NAMESPACE
