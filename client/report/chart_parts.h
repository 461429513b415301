// What charts of several jobs share.
#pragma once

#include <cstddef>
#include <vector>

#include "client/charts/chart.h"
#include "client/laboratory/laboratory_curve.h"

namespace creepctl {

/// The colours in turn, then again with dashes, then dotted.
void tell_apart(Series& series, std::size_t number);

Axis creep_time_axis();

/// "1 s" to "30 d" along the top.
std::vector<Landmark> creep_time_landmarks();

/// The points of each curve, strain in per cent.
void add_laboratory(Chart& chart, const std::vector<LaboratoryCurve>& laboratory);

}  // namespace creepctl
