// Rows of the tables of a job, read off the state. Order and meaning of the values: record.cpp.
#pragma once

#include <string>
#include <vector>

#include "core/dem/contact_model.h"
#include "core/output/record.h"
#include "core/state/state.h"

namespace creep {

/// creep_time of the present hold [s]; 0 outside a hold.
double creep_time(const RunState& state);

std::vector<double> sample_values(const RunState& state, const Experiment& experiment,
                                  const ContactModel& model, Phase phase);
std::vector<double> stage_values(const RunState& state, const Loading& loading, bool settled,
                                 const Experiment& experiment);
std::vector<double> stage_values(const RunState& state, const DynamicStage& stage, bool settled,
                                 const Experiment& experiment);
/// Before the split, while the particle is still there.
std::vector<double> breakage_values(const RunState& state, const Failure& failure);

/// The grading curve of the present specimen, a row of values a point.
std::vector<std::vector<double>> grading_values(const RunState& state, const Experiment& experiment);

/// Final figures for summary.json, each as name, value; the order is kept.
struct SummaryFigure {
  std::string name;  ///< with the SI unit as suffix, as in the csv columns
  double value = 0.0;
};

std::vector<SummaryFigure> summary_figures(const RunState& state, const Experiment& experiment,
                                           const ContactModel& model);

}  // namespace creep
