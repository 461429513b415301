// What of a run is written, and in which order: each visit names every field once, for writing, reading and
// digesting alike. `Of` is T or const T.
#pragma once

#include <cstdint>
#include <type_traits>
#include <utility>
#include <variant>
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

template <class Archive, class Optional, class Visit>
void visit_optional(Archive& archive, Optional& value, Visit visit) {
  bool there = value.has_value();
  archive(there);
  if constexpr (Archive::kReading) {
    value.reset();
    if (there) value.emplace();
  }
  if (value) visit(*value);
}

template <class Archive, class Of>
void visit_packing(Archive& archive, Of& packing) {
  archive(packing.step);
  archive(packing.growth);
  archive(packing.step_cycle);
  archive(packing.quiet_since);
  archive(packing.lowest_void_ratio);
  archive(packing.stop_void_ratio);
  archive(packing.falls);
  archive(packing.generation_friction);
}

template <class Archive, class Of>
void visit_stage_start(Archive& archive, Of& start) {
  archive(start.creep_time);
  archive(start.suspended_time);
  archive(start.broken_at_start);
  archive(start.broken_before);
}

template <class Archive, class Of>
void visit_calm(Archive& archive, Of& calm) {
  archive(calm.cycle);
  archive(calm.quiet_since);
  visit_optional(archive, calm.on_target, [&](auto& cycle) { archive(cycle); });
}

template <class Archive, class Of>
void visit_hold(Archive& archive, Of& hold) {
  archive(hold.start.age);
  archive(hold.start.axial_strain);
  archive(hold.start.axial_stress);
  archive(hold.start.void_ratio);
  archive(hold.start.broken_total);
  archive(hold.ageing_jumps);
  archive(hold.dynamic_stages);
  archive(hold.largest_ripple);
  archive(hold.next_snapshot_age);
  archive(hold.breakages);
  visit_optional(archive, hold.promise, [&](auto& promise) {
    archive(promise.aged_from);
    archive(promise.promised);
  });
}

/// What an act remembers.
template <class Archive, class Of>
void visit_one_act(Archive& archive, Of& act) {
  using One = std::remove_const_t<Of>;
  if constexpr (std::is_same_v<One, PackingState>) {
    visit_packing(archive, act);
  } else if constexpr (std::is_same_v<One, Loading>) {
    visit_stage_start(archive, act.start);
    visit_calm(archive, act.calm);
    archive(act.begun_at);
    visit_optional(archive, act.next_sample, [&](auto& at) { archive(at); });
    archive(act.kept);
  } else if constexpr (std::is_same_v<One, DynamicStage>) {
    visit_stage_start(archive, act.start);
    visit_calm(archive, act.calm);
    archive(act.closing);
    archive(act.ripple);
    visit_optional(archive, act.drift, [&](auto& drift) {
      archive(drift.cycle);
      archive(drift.end_of_ageing);
      visit_optional(archive, drift.change, [&](auto& change) { archive(change); });
    });
    visit_optional(archive, act.strain_half_way, [&](auto& strain) { archive(strain); });
  } else if constexpr (std::is_same_v<One, Between> || std::is_same_v<One, Done>) {
    archive(act.after_hold);
  } else {
    static_assert(std::is_empty_v<One>, "an act with something to remember that nobody writes");
  }
}

/// By its place among the alternatives of Act: new ones go to the end.
template <class Archive, class Of>
void visit_act(Archive& archive, Of& act) {
  std::uint64_t which = act.index();
  archive(which);
  if constexpr (Archive::kReading) {
    if (which >= std::variant_size_v<Act>) return archive.refuse();
    [&]<std::size_t... k>(std::index_sequence<k...>) {
      ((which == k ? static_cast<void>(act.template emplace<k>()) : void()), ...);
    }
    (std::make_index_sequence<std::variant_size_v<Act>>());
  }
  std::visit([&](auto& one) { visit_one_act(archive, one); }, act);
}

/// All of a run beside its specimen.
template <class Archive, class Of>
void visit_run(Archive& archive, Of& state) {
  visit_act(archive, state.act);
  archive(state.stage);
  archive(state.curves);
  visit_optional(archive, state.packed, [&](auto& packed) {
    archive(packed.count);
    archive(packed.void_ratio);
    archive(packed.grading_index);
    archive(packed.generation_friction);
  });
  archive(state.aim.sides);
  archive(state.aim.axial);
  archive(state.aim.radial);
  archive(state.peak.deviatoric_stress);
  archive(state.peak.axial_strain);
  visit_optional(archive, state.hold, [&](auto& hold) { visit_hold(archive, hold); });
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
