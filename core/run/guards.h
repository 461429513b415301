// When a run must not go on, as values: each guard looks at what a cycle or a sample found and gives the
// outcome, with a name, the measured number beside its limit, and what cures it. A sound run never meets one.
#pragma once

#include <optional>
#include <string>

#include "core/dem/dynamics.h"
#include "core/dem/measures.h"
#include "core/dem/specimen.h"
#include "core/experiment/experiment.h"
#include "core/output/outcome.h"
#include "core/state/state.h"

namespace creep {

/// A guard stop for `reason`, "NAME: what was found".
Outcome guard_stop(const std::string& reason, std::string advice);

/// non-finite, overlap, step: by what one cycle found.
std::optional<Outcome> cycle_guard(const CycleResult& result);

/// energy: more than was put in. @param unexplained  of the ledger, negative for a gain [J]
std::optional<Outcome> energy_guard(const EnergyLedger& energy, double unexplained);

/// servo: a wall that had reached its stress runs away. @param off_target  |stress / target - 1|
std::optional<Outcome> servo_guard(double off_target);

/// inertia, loading: grains collide instead of bearing load, or the specimen is too weak for its target.
std::optional<Outcome> loading_guard(const Specimen& specimen, const Experiment& experiment,
                                     const Target& target);

/// stress: at the end of a stage that did not settle, walls and contacts tell different stresses. @param gap
/// stress_gap()
std::optional<Outcome> stress_guard(const std::string& where, const Specimen& specimen,
                                    const ContactStress& carried, double gap, double tolerance);

/// settling: a stage that found no equilibrium. @param where  names it
Outcome settling_stop(const std::string& where, const Calm& calm, const Specimen& specimen);

}  // namespace creep
