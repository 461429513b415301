// The mean over several specimens and how well it is known.
#pragma once

#include <cstddef>
#include <optional>
#include <span>

namespace creep {

inline constexpr double kConfidence = 0.95;  ///< share of such intervals that hold the mean of all specimens

/// The t below which a share `probability` of Student's distribution lies, for 0.5 <= probability < 1 and at
/// least one degree of freedom. From the finite series of the distribution for whole degrees of freedom
/// (Abramowitz & Stegun 26.7.3, 26.7.4), to 1e-10 of t.
double student_t_quantile(double probability, std::size_t degrees_of_freedom);

struct EnsembleMean {
  double mean = 0.0;
  /// Of the two-sided interval of confidence kConfidence about the mean, of normally scattered values whose
  /// scatter is not known beforehand: t s / sqrt(n). None for one value: it has no uncertainty that is known.
  std::optional<double> half_width;
  std::size_t count = 0;

  double low() const { return mean - half_width.value_or(0.0); }
  double high() const { return mean + half_width.value_or(0.0); }
};

/// nullopt without a value. All must be finite.
std::optional<EnsembleMean> ensemble_mean(std::span<const double> values);

}  // namespace creep
