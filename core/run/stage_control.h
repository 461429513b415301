// What the walls do in each stage, and when a loading stage has reached its target.
#pragma once

#include "core/dem/servo.h"
#include "core/dem/specimen.h"
#include "core/experiment/experiment.h"
#include "core/state/state.h"

namespace creep {

/// The present value of a measure, by wall forces and positions [Pa] or [-].
double value_of(Target::Measure measure, const Specimen& specimen);

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
