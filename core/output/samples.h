// Rows of the tables of a job, read off the state. Order and meaning of the values: record.cpp.
#pragma once

#include <vector>

#include "core/dem/contact_model.h"
#include "core/output/record.h"
#include "core/state/state.h"

namespace creep {

/// creep_time of the present hold [s]; 0 outside a hold.
double creep_time(const RunState& state);

/// Axial strain rate x d50 x sqrt(density / mean stress) [-]; 0 without stress.
double inertial_number(const Specimen& specimen, const Experiment& experiment);

/// Closing speed of the platens [m/s] at which I = (v / L) d50 sqrt(rho / p) equals `limit`:
/// v = limit (L / d50) sqrt(p / rho). A p below the stress of packing counts as that: the platens do not stop
/// where they have lost their contacts.
double closing_velocity_at(double limit, const Specimen& specimen, const Experiment& experiment);

std::vector<double> sample_values(const RunState& state, const Experiment& experiment,
                                  const ContactModel& model, Phase phase);
std::vector<double> stage_values(const RunState& state, const Experiment& experiment, bool settled);
/// Before the split, while the particle is still there.
std::vector<double> breakage_values(const RunState& state, const Failure& failure);

/// The grading curve of the present specimen, a row of values a point.
std::vector<std::vector<double>> grading_values(const RunState& state, const Experiment& experiment);

std::vector<SummaryFigure> summary_figures(const RunState& state, const Experiment& experiment,
                                           const ContactModel& model);

}  // namespace creep
