// Axes of a chart: ranges, ticks and their labels. Pure geometry, no drawing.
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace creepctl {

enum class Scale { kLinear, kLog };

struct AxisRange {
  double low = 0.0;
  double high = 1.0;
};

struct Tick {
  double value = 0.0;
  std::string label;  ///< "" for a minor tick; "10^{−3}" stands for a raised exponent
  bool major = false;
};

/// Can the value be placed on such an axis: finite, and positive if logarithmic?
bool drawable(Scale scale, double value);

/// Smallest range of the drawable values; nullopt if there is none.
std::optional<AxisRange> data_range(Scale scale, const std::vector<double>& values);

/// The data range widened to where an axis should begin and end. Never empty: constant data get room on both
/// sides. A linear range that comes near zero begins there.
AxisRange axis_range(Scale scale, AxisRange data);

/// Ticks inside the range, in rising order. At least two of them have a label.
std::vector<Tick> axis_ticks(Scale scale, AxisRange range, int most_labels);

/// Place along the axis: 0 at its low end, 1 at its high end.
double axis_position(Scale scale, AxisRange range, double value);

/// The number in the fewest digits that tell it apart from its neighbours `step` away.
std::string tick_label(double value, double step);

}  // namespace creepctl
