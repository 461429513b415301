// The two kernels of a cycle and their compiled variants. (kernel)
//
//   contacts:  positions, velocities, shear history -> force of every contact, added to both its particles
//   particles: resultant + wall contacts -> kick, drift
//
// A particle's resultant is the sum over neighbours in ascending id, then walls 0 to 5. Contacts come in
// ascending (first, second), so adding each to its particles in turn gives that order: all neighbours of
// lower id own earlier contacts. Where the contacts of a particle fall to different threads ("shared"),
// forces go to slots instead, one a contact, and the particle kernel adds them in the same order. Measuring
// cycles add up stiffnesses and the largest stress of each particle as well.
//
// There is one set of kernels an instruction set; "portable" is the plain scalar twin that tests hold the
// others against. All sets compute the same bits. Sums over particles or contacts come back as integers of
// fixed quanta (specimen.h), so the share a thread computes does not matter.
#pragma once

#include <cstddef>
#include <cstdint>

#include "core/dem/body.h"

namespace creep {

/// What kernels read of a LawTable (physics/contact_law.h, where the canonical evaluation stands).
struct LawView {
  const double* cells = nullptr;  ///< 4 coefficients a cell; nullptr: smooth Hertz
  double inverse_delta_T1 = 0.0;  ///< [1/m]
  double delta_T2 = 0.0;          ///< [m]
  double hertz_offset = 0.0;      ///< [m]
  std::int64_t before_first_cell = 0;
  int cell_shift = 45;
  std::int64_t base_mask = 0;  ///< clears the low cell_shift bits
};

/// Threads compute contacts in multiples of this, the widest vector.
inline constexpr std::size_t kKernelGrain = 8;
inline constexpr std::uint8_t kDeferFirst = 1, kDeferSecond = 2;

/// Input and output of the contact kernel; pointers as in Contacts, arrays padded to 8.
struct ContactPhase {
  const Body* body = nullptr;
  const std::int32_t* first = nullptr;
  const std::int32_t* second = nullptr;
  const double* root_radius = nullptr;
  double* shear_x = nullptr;
  double* shear_y = nullptr;
  double* shear_z = nullptr;
  ContactForce* force = nullptr;           ///< slots, of deferred contacts
  ContactForce* resultant = nullptr;       ///< of particles; zero at the start of a cycle
  const std::uint8_t* deferred = nullptr;  ///< kDeferFirst, kDeferSecond
  double* stress = nullptr;                ///< slots, as force; measuring cycles only
  double* peak_stress = nullptr;           ///< of particles, as resultant; measuring cycles only
  const Spin* spin = nullptr;              ///< of particles; nullptr: rotation is blocked, and costs nothing
  ContactForce* couple =
      nullptr;  ///< normal x tangential force [N]: times its radius the moment on a particle
  LawView law;
  double modulus = 0.0;           ///< E' [Pa]
  double tangential_ratio = 0.0;  ///< kt/kn [-]
  double friction = 0.0;          ///< mu [-]
  double drift = 0.0;             ///< step between the last positions and these [s]
  bool ask_ahead = false;         ///< the particles are more than the caches hold; changes no result
};

struct ContactSums {
  std::int64_t tangential_work = 0;    ///< in 2^kEnergyQuantum J
  std::int64_t friction = 0;           ///< in 2^kEnergyQuantum J
  std::int64_t force = 0;              ///< of magnitudes, in 2^kForceQuantum N; measuring cycles only
  std::int64_t overlap = 0;            ///< in 2^kLengthQuantum m; measuring cycles only
  std::int64_t touching = 0;           ///< contacts; measuring cycles only
  double largest_overlap_ratio = 0.0;  ///< overlap over the smaller radius; measuring cycles only
  bool breaking = false;               ///< some contact stress exceeds a limit; checking cycles only
};

struct ParticlePhase {
  Body* body = nullptr;
  const ContactForce* force = nullptr;
  ContactForce* resultant = nullptr;      ///< left zero for the next cycle
  const std::uint8_t* shared = nullptr;   ///< 1: add up slots instead
  const std::int32_t* special = nullptr;  ///< particles that are shared or near walls, ascending
  std::size_t special_count = 0;
  const double* stress = nullptr;
  double* peak_stress = nullptr;  ///< left zero for the next cycle
  const std::int32_t* own_begin = nullptr;
  const std::int32_t* lower_begin = nullptr;
  const std::int32_t* lower_contact = nullptr;
  const std::uint8_t* near_walls = nullptr;
  const ListReference* reference = nullptr;
  const double* inertial_mass = nullptr;
  double* mobilised_stress = nullptr;
  double* breaking =
      nullptr;  ///< set to sigma_mob/sigma_lim > 1 where a particle breaks at a wall; checking cycles
  WallShear* wall_shear = nullptr;  ///< nullptr: walls are frictionless, and that costs nothing
  const Spin* spin = nullptr;       ///< as in ContactPhase; read where walls rub
  double wall_position[6] = {};
  LawView law;
  double wall_friction = 0.0;     ///< mu at walls [-]
  double tangential_ratio = 0.0;  ///< kt/kn [-]
  double last_drift = 0.0;        ///< step between the last positions and these [s]
  double wall_modulus = 0.0;      ///< E' at walls [Pa]
  double local_damping = 0.0;     ///< alpha [-]
  double kick = 0.0;              ///< step of the velocity [s]
  double drift = 0.0;             ///< step of the position [s]
  double floor_stiffness = 0.0;   ///< stiffness over sqrt(radius) of a particle without contact [N/m^1.5]
};

struct ParticleSums {
  std::int64_t wall_force[6] = {};           ///< in 2^kForceQuantum N
  std::int64_t wall_stiffness[6] = {};       ///< in 2^kStiffnessQuantum N/m
  std::int64_t tangential_work = 0;          ///< at walls, in 2^kEnergyQuantum J
  std::int64_t friction = 0;                 ///< at walls, in 2^kEnergyQuantum J
  std::int64_t damping = 0;                  ///< work, in 2^kEnergyQuantum J
  bool list_ends = false;                    ///< some particle went as far as the list holds
  std::int64_t resultant = 0;                ///< of magnitudes, in 2^kForceQuantum N; measuring cycles only
  std::int64_t with_contacts = 0;            ///< particles; measuring cycles only
  double largest_stiffness_over_mass = 0.0;  ///< [1/s2]; measuring cycles only
  bool finite = true;                        ///< measuring cycles only
  bool breaking = false;                     ///< some particle breaks at a wall; checking cycles only
};

/// What a cycle does beyond moving; each combination is compiled on its own.
struct CycleKind {
  bool measure = false;  ///< contact stresses, sums of forces, stiffness over mass
  bool check = false;    ///< immediate failure
  bool move = true;      ///< false: forces only
};

struct Kernels {
  const char* name;
  void (*contacts)(const ContactPhase&, CycleKind, std::size_t begin, std::size_t end, ContactSums&);
  void (*particles)(const ParticlePhase&, CycleKind, std::size_t begin, std::size_t end, ParticleSums&);
};

const Kernels& portable_kernels();
/// nullptr where the program was built without them or the processor lacks them.
const Kernels* avx2_kernels();
const Kernels* avx512_kernels();

/// x / 2^exponent rounded to an integer, the same in every instruction set. |x| is clamped to 2^50 quanta;
/// the guards of a run stop it long before.
namespace quanta {
inline constexpr double kMagic = 0x1.8p52;
inline constexpr double kLimit = 0x1p50;
}  // namespace quanta

}  // namespace creep
