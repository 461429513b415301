// What the walls do in each stage, and when a loading stage has reached its target.
#pragma once

#include "core/dem/servo.h"
#include "core/dem/specimen.h"
#include "core/experiment/experiment.h"
#include "core/state/state.h"

namespace creep {

/// Closing speed of the platens [m/s] at which I = (v / L) d50 sqrt(rho / p) equals `limit`:
/// v = limit (L / d50) sqrt(p / rho). A p below the stress of packing counts as that: the platens do not stop
/// where they have lost their contacts.
double closing_velocity_at(double limit, const Specimen& specimen, const Experiment& experiment);

/// Sets what the stage asks of the walls: `sides`, `target` and `radial_target` of the cursor. What it does
/// not ask for stays as it was held, or is taken from the specimen as it stands.
void take_aim(Cursor& cursor, const Stage& stage, const Specimen& specimen);

/// The control of one cycle.
WallControl wall_control(const Stage& stage, const Cursor& cursor, const Numerics& numerics);

/// True for stages that end at rest at their stress, rather than on passing it: isotropic and unloading ones.
bool comes_to_rest(const Stage& stage);

/// Whether a loading stage that does not come to rest has passed its target. `tolerance`: of a stress that
/// walls are steered to, which slow down before it [-].
bool has_passed(const Stage& stage, const Cursor& cursor, const Specimen& specimen, double tolerance);

/// Largest |stress / target - 1| over the pairs of walls that hold a stress now; the axial pair of a
/// relaxation holds none.
double off_target(const Stage& stage, const Cursor& cursor, const Specimen& specimen);

/// After a loading stage: `target` becomes the axial stress that it has reached.
void keep_aim(Cursor& cursor, const Stage& stage, const Specimen& specimen);

}  // namespace creep
