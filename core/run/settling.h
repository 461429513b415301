// When a stage has come to rest: judged on what each cycle found, and kept in values that begin with the
// stage.
#pragma once

#include <cstdint>
#include <optional>

#include "core/dem/contact_model.h"
#include "core/dem/specimen.h"
#include "core/experiment/experiment.h"
#include "core/state/state.h"

namespace creep {

/// Cycles on target and without a failure that end a stage.
std::int64_t settle_window(const Numerics& numerics);
/// A stage that takes longer does not settle.
std::int64_t most_cycles(const Numerics& numerics);

/// How far off target the walls are that hold a stress [-]. A stage that holds its strain is compared with
/// its own stress, which `aim` follows: it has settled once that stands still.
double watch_stress(Aim& aim, const Stage& stage, const Specimen& specimen, const Numerics& numerics);

/// What the cycle just computed, `calm.cycle`, was like.
void watch_calm(Calm& calm, double deviation, bool failed, const Numerics& numerics);

/// On target and without a failure for a window, and in equilibrium.
bool at_rest(const Calm& calm, const Specimen& specimen, const Numerics& numerics);

/// How much of the stress at the walls the contacts do not carry, or carry more [-]: largest difference of
/// axial and radial stress, over the larger at the walls. At rest both are the same stress. Needs a valid
/// list.
double stress_gap(const Specimen& specimen, const ContactModel& model);

/// Once a window, in a cycle that measured (sigma_mob is not in a checkpoint), how far off the end of the
/// next ageing lies. @param breakages  n_age of it. @param left  of the hold [s]
void watch_failure_times(DynamicStage& stage, const Specimen& specimen, const Experiment& experiment,
                         std::int64_t breakages, double left);
/// Whether it stood still over the last window, if the experiment asks for that.
bool failure_times_stand(const DynamicStage& stage, const Numerics& numerics);

}  // namespace creep
