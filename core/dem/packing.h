// Makes the specimen: radius expansion, isotropic compression, then lowered friction until the target void
// ratio.
//
// With rotation blocked the friction in use decides the void ratio at a given stress, so it is searched for:
// the box holds the isotropic stress by servo while friction falls slowly; near the target void ratio the
// friction of the material is restored and equilibrium awaited. A specimen still compacts while it settles,
// so the first fall ends early and further falls take it to the target. The friction at the end of the last
// is the generation friction, a result that is reported. Strains are zero at the end.
//
//   grow -> compress -> lower friction <-> restore -> done
#pragma once

#include <cstdint>
#include <string>

#include "core/dem/dynamics.h"
#include "core/dem/specimen.h"
#include "core/experiment/experiment.h"

namespace creep {

/// How far packing has come; part of a checkpoint.
struct PackingState {
  enum class Step : std::uint8_t { kGrow, kCompress, kLowerFriction, kRestore, kDone };
  Step step = Step::kGrow;
  double growth = 0.0;               ///< present radius over final radius
  std::int64_t step_cycle = 0;       ///< since the step began
  std::int64_t quiet_since = 0;      ///< step_cycle from which the stress has been on target
  double lowest_void_ratio = 0.0;    ///< before the present window of a specimen at zero friction
  double stop_void_ratio = 0.0;      ///< at which the present fall of friction ends
  std::int64_t falls = 0;            ///< of friction, so far
  double generation_friction = 0.0;  ///< found
};

/// How the packing went wrong; empty if it did not.
using PackingFault = std::string;

/// Particles at half their radius, at random without overlap, in a box that is looser than wanted.
Specimen scatter(const Experiment& experiment);

/// One cycle of packing. On reaching kDone, ids are in space-filling order, strengths and cracks are drawn,
/// clocks and ledger are zero. Returns a fault if it cannot settle.
PackingFault pack_one_cycle(Specimen& specimen, PackingState& state, const Experiment& experiment,
                            Dynamics& dynamics);

}  // namespace creep
