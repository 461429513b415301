// The mean of several curves over log time, with its confidence band. Pure.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

namespace creepctl {

/// Points in rising order of x > 0, linear in ln x between them.
struct Curve {
  std::vector<double> x;
  std::vector<double> y;
};

struct MeanCurve {
  std::vector<double> x;  ///< evenly spaced in ln x, where all curves are
  std::vector<double> mean;
  std::vector<double> low;  ///< of Student's 95 % interval; empty for one curve
  std::vector<double> high;
  std::size_t count = 0;  ///< curves
};

enum class MeanOf {
  kValues,
  kLogarithms,  ///< geometric means; points with y <= 0 are left out
};

/// Over the range that all curves cover: beyond it the mean would be that of the ones which go on. One curve
/// is its own mean, at its own points. nullopt if there is no curve or no such range.
std::optional<MeanCurve> mean_curve(const std::vector<Curve>& curves, MeanOf what);

}  // namespace creepctl
