// What of a run is written, and in which order: each visit names every field once, for writing, reading and
// digesting alike. `Of` is T or const T.
#pragma once

#include <cstdint>
#include <vector>

#include "core/dem/shear_history.h"
#include "core/state/checkpoint.h"
#include "core/state/state.h"

namespace creep {

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

}  // namespace creep
