// What the walls do in each stage, and when a loading stage has reached its target: whatever differs from
// one kind of stage to another stands here.
#pragma once

#include <cstdint>
#include <optional>

#include "core/dem/servo.h"
#include "core/dem/specimen.h"
#include "core/experiment/experiment.h"
#include "core/state/state.h"

namespace creep {

/// Closing speed of the platens [m/s] at which I = (v / L) d50 sqrt(rho / p) equals `limit`:
/// v = limit (L / d50) sqrt(p / rho). A p below the stress of packing counts as that: the platens do not stop
/// where they have lost their contacts.
double closing_velocity_at(double limit, const Specimen& specimen, const Experiment& experiment);

/// Sets what the stage asks of the walls. What it does not ask for stays as it was held, or is taken from the
/// specimen as it stands.
void take_aim(Aim& aim, const Stage& stage, const Specimen& specimen);

/// The control of one cycle.
WallControl wall_control(const Stage& stage, const Aim& aim, const Numerics& numerics);

/// True for stages that end at rest at their stress, rather than on passing it: isotropic and unloading ones.
bool comes_to_rest(const Stage& stage);

/// True for a relaxation: the axial walls stand, their stress decays.
bool holds_strain(const Stage& stage);

/// True for a triaxial stage: its largest deviatoric stress is a result.
bool has_peak(const Stage& stage);

/// Whether a loading stage that does not come to rest has passed its target. `tolerance`: of a stress that
/// walls are steered to, which slow down before it [-].
bool has_passed(const Stage& stage, const Aim& aim, const Specimen& specimen, double tolerance);

/// Largest |stress / target - 1| over the pairs of walls that hold a stress now; the axial pair of a
/// relaxation holds none.
double off_target(const Stage& stage, const Aim& aim, const Specimen& specimen);

/// After a loading stage: `axial` becomes the axial stress that it has reached.
void keep_aim(Aim& aim, const Stage& stage, const Specimen& specimen);

/// Whether a loading stage gives a sample now; then `next` becomes where it gives the one after.
bool sample_is_due(std::optional<double>& next, const Stage& stage, const Specimen& specimen);

/// Multiples of the step to keep at or below the present value; when unloading, at or above it.
std::int64_t steps_passed(const Stage& stage, const Specimen& specimen);
/// Whether `passed` lies beyond those `kept` already.
bool goes_beyond(const Stage& stage, std::int64_t passed, std::int64_t kept);

}  // namespace creep
