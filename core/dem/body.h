// Records that the kernels share with the rest. Nothing else is included here: kernel sources are compiled
// for wide instruction sets, and an inline function of a library compiled there could be linked into
// everything.
#pragma once

#include <cstdint>

namespace creep {

/// What kernels need of one particle: one cache line, loaded whole.
struct alignas(64) Body {
  double x, y, z;          ///< centre [m]
  double radius;           ///< [m]
  double vx, vy, vz;       ///< velocity half a step behind the position [m/s]
  double breaking_stress;  ///< pi sigma_lim [Pa]; +infinity for a particle that cannot fail
};

/// Angular velocity, half a step behind [rad/s].
struct alignas(32) Spin {
  double x, y, z, unused;
};

/// Tangential force of a wall on a particle [N]: of the walls across axis a along the axes a+1 and a+2, in
/// turn. A particle never touches both walls of an axis: no box is that thin.
struct WallShear {
  double across[3][2];
};

/// Force of one contact on its first particle [N], with the contact's normal stiffness [N/m] beside it.
struct alignas(32) ContactForce {
  double x, y, z, stiffness;
};

/// Where a particle stood when the contact list was made, and how far it may go before the list must be made
/// anew.
struct alignas(32) ListReference {
  double x, y, z;        ///< [m]
  double reach_squared;  ///< [m2]
};

/// Quanta of the order-free sums: fine enough that rounding stays below 1e-15 of any total of a run.
inline constexpr int kEnergyQuantum = -70;     ///< exponent of 2 [J]
inline constexpr int kForceQuantum = -40;      ///< exponent of 2 [N]
inline constexpr int kStiffnessQuantum = -20;  ///< exponent of 2 [N/m]
inline constexpr int kLengthQuantum = -60;     ///< exponent of 2 [m]

}  // namespace creep
