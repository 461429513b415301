// The specimen. Of it and of what a run does with it (state/state.h) nothing is lost in a crash, but for the
// work spaces of kernels and sigma_mob of the last measuring cycle, which are made anew. Particles stand in
// ascending id everywhere: the index changes when particles break, the order never does. Ids are given in
// space-filling order at the end of packing and are never reused.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "core/arithmetic/fixed_point.h"
#include "core/dem/aligned.h"
#include "core/dem/body.h"

namespace creep {

/// n particles; index i of every array is the same particle.
struct Particles {
  AlignedVector<Body> body;
  std::vector<std::uint64_t> id;         ///< ascending
  std::vector<std::uint64_t> parent;     ///< id of the particle it came from; its own id if initial
  std::vector<std::int32_t> generation;  ///< 0 initial, 1 fragment, 2 fragment of a fragment
  std::vector<double> mass;              ///< physical [kg]
  std::vector<double> inertial_mass;     ///< used by the equation of motion [kg]
  std::vector<double> limit_stress;      ///< sigma_lim [Pa] (eq 11)
  std::vector<double> crack;             ///< half-length a [m] (eq 21)
  std::vector<double> mobilised_stress;  ///< sigma_mob of the last measuring cycle [Pa] (eq 12)
  AlignedVector<Spin> spin;              ///< n where rotation is free, else empty
  std::vector<WallShear> wall_shear;     ///< n where walls rub, from the end of packing on; else empty

  std::size_t size() const { return body.size(); }
  Eigen::Vector3d position(std::size_t i) const { return {body[i].x, body[i].y, body[i].z}; }
  Eigen::Vector3d velocity(std::size_t i) const { return {body[i].vx, body[i].vy, body[i].vz}; }
};

/// m candidate pairs within the skin, in ascending (first, second): the list is derived from positions, the
/// shear force is history. A pair that does not touch has zero shear and zero force.
struct Contacts {
  std::vector<std::int32_t> first, second;  ///< particle indices, first < second; padded to a multiple of 8
  AlignedVector<double> root_radius;        ///< sqrt(r') [m^0.5], padded
  AlignedVector<double> shear_x, shear_y, shear_z;  ///< tangential force on first [N], padded
  AlignedVector<ContactForce> force;                ///< of deferred contacts, padded; a work space of kernels
  AlignedVector<ContactForce> couple;       ///< padded where rotation is free; a work space of kernels
  AlignedVector<ContactForce> resultant;    ///< n: zero between cycles; a work space of kernels
  AlignedVector<double> peak_stress;        ///< n: zero between cycles; a work space of kernels
  std::vector<std::uint8_t> deferred;       ///< padded: which ends are added up by the particle kernel
  std::vector<std::uint8_t> shared;         ///< n: 1 if the contacts fall to different threads
  AlignedVector<double> stress;             ///< F/(pi r' delta) of deferred ones, padded; a work space [Pa]
  std::size_t count = 0;                    ///< m, without padding
  std::vector<std::int32_t> own_begin;      ///< n+1: contacts of which i is first
  std::vector<std::int32_t> lower_begin;    ///< n+1: places in lower_contact of those of which i is second
  std::vector<std::int32_t> lower_contact;  ///< ascending first
  std::vector<std::uint8_t> near_walls;     ///< n: bit w set if wall w is within the skin
  std::vector<std::int32_t> special;        ///< particles that are shared or near walls, ascending
  std::vector<std::size_t>
      particle_shares;                     ///< borders of the shares of the particle kernel, about equal work
  AlignedVector<ListReference> reference;  ///< n: how far the list holds
  std::array<double, 6> wall_reference{};  ///< wall positions then [m]
  bool valid = false;                      ///< false: must be searched anew before the next cycle
};

/// Six rigid walls of the box; wall 2a is the low one of axis a, 2a+1 the high one.
struct Walls {
  std::array<double, 6> position{};   ///< along its axis [m]
  std::array<double, 6> velocity{};   ///< along its axis, half a step behind [m/s]
  std::array<double, 6> force{};      ///< reaction, compression positive [N]
  std::array<double, 6> stiffness{};  ///< summed normal stiffness of its contacts [N/m]
  std::array<double, 3> carried{};    ///< inward velocity of a pair that follows its specimen (servo.h) [m/s]

  double length(std::size_t axis) const { return position[2 * axis + 1] - position[2 * axis]; }
  double area(std::size_t axis) const { return length((axis + 1) % 3) * length((axis + 2) % 3); }
  double volume() const { return length(0) * length(1) * length(2); }
  /// Mean stress of the two walls of an axis, compression positive [Pa].
  double stress(std::size_t axis) const { return 0.5 * (force[2 * axis] + force[2 * axis + 1]) / area(axis); }
};

/// Two clocks, never one. All [s].
struct Clocks {
  double age = 0.0;             ///< laboratory time passed off-DEM
  double dynamic_time = 0.0;    ///< physical time passed in dynamic computation
  double suspended_time = 0.0;  ///< dynamic time with scaled inertia: not physical, in no other clock
  double hold_start = 0.0;      ///< age + dynamic_time when the present hold began
  double creep_time() const { return age + dynamic_time - hold_start; }
};

/// Mass lost in one split, a fractal grading below its smallest sibling.
struct Fines {
  double mass = 0.0;              ///< [kg]
  double smallest_sibling = 0.0;  ///< diameter [m]
};

/// Energy since the end of packing [J]. Tangential work is summed contact by contact, never as a balance.
struct EnergyLedger {
  double wall_work = 0.0;
  FixedSum tangential_work{kEnergyQuantum};
  FixedSum friction{kEnergyQuantum};
  FixedSum damping{kEnergyQuantum};
  double removed_normal = 0.0;      ///< normal elastic energy removed by splits
  double removed_tangential = 0.0;  ///< tangential elastic energy removed by splits
  double removed_kinetic = 0.0;
  double initial_stored = 0.0;      ///< normal elastic + kinetic when the ledger began
  double initial_tangential = 0.0;  ///< tangential elastic then
};

struct Specimen {
  Particles particles;
  Contacts contacts;
  Walls walls;
  Clocks clocks;
  EnergyLedger energy;
  std::vector<Fines> fines;
  double initial_mass = 0.0;            ///< [kg]
  double initial_height = 0.0;          ///< at zero strain [m]
  double initial_volume = 0.0;          ///< at zero strain [m3]
  double friction = 0.0;                ///< between grains, in use [-]
  double time_step = 0.0;               ///< of the next drift [s]
  double last_time_step = 0.0;          ///< of the last drift [s]; 0 before the first
  double crack_time = 0.0;              ///< dynamic time since cracks last grew [s]
  double unbalanced_force_ratio = 1.0;  ///< of the last measuring cycle [-]
  double mean_overlap = 0.0;            ///< over touching contacts, last measuring cycle [m]
  std::uint64_t next_id = 0;
  std::int64_t cycle = 0;  ///< since the start of the run
  std::int64_t broken_total = 0;
};

}  // namespace creep
