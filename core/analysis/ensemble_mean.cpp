#include "core/analysis/ensemble_mean.h"

#include <cmath>
#include <numbers>

#include "core/arithmetic/check.h"

namespace creep {
namespace {

/// The share of the distribution between -t and t.
double share_within(double t, std::size_t degrees_of_freedom) {
  const double angle = std::atan(t / std::sqrt(static_cast<double>(degrees_of_freedom)));
  const double sine = std::sin(angle);
  const double cosine = std::cos(angle);
  const bool odd = degrees_of_freedom % 2 == 1;
  double term = odd ? cosine : 1.0;
  double sum = degrees_of_freedom == 1 ? 0.0 : term;
  for (std::size_t k = odd ? 3 : 2; k + 2 <= degrees_of_freedom; k += 2) {
    const auto factor = static_cast<double>(k);
    term *= cosine * cosine * (factor - 1.0) / factor;
    sum += term;
  }
  return odd ? 2.0 / std::numbers::pi * (angle + sine * sum) : sine * sum;
}

}  // namespace

double student_t_quantile(double probability, std::size_t degrees_of_freedom) {
  CREEP_CHECK(probability >= 0.5 && probability < 1.0 && degrees_of_freedom >= 1,
              "a quantile of Student's distribution that there is not");
  const double wanted = 2.0 * probability - 1.0;
  double low = 0.0;
  double high = 1.0;
  while (share_within(high, degrees_of_freedom) < wanted) high *= 2.0;
  for (int i = 0; i < 60 && high - low > 1e-12 * high; ++i) {
    const double middle = 0.5 * (low + high);
    (share_within(middle, degrees_of_freedom) < wanted ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

std::optional<EnsembleMean> ensemble_mean(std::span<const double> values) {
  if (values.empty()) return std::nullopt;
  const auto count = static_cast<double>(values.size());
  EnsembleMean result;
  result.count = values.size();
  for (const double value : values) result.mean += value / count;
  if (values.size() < 2) return result;
  double squares = 0.0;
  for (const double value : values) squares += (value - result.mean) * (value - result.mean);
  const double deviation = std::sqrt(squares / (count - 1.0));
  result.half_width =
      student_t_quantile(0.5 + 0.5 * kConfidence, values.size() - 1) * deviation / std::sqrt(count);
  return result;
}

}  // namespace creep
