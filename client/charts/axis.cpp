#include "client/charts/axis.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace creepctl {
namespace {

/// Largest of 1, 2, 5 x 10^k that is at least `least`.
double round_step(double least) {
  const double decade = std::pow(10.0, std::floor(std::log10(least)));
  for (const double factor : {1.0, 2.0, 5.0}) {
    if (factor * decade >= least * (1.0 - 1e-9)) return factor * decade;
  }
  return 10.0 * decade;
}

/// Nearest 1, 2, 5 x 10^k at or below (up = false) or at or above (up = true).
double round_125(double value, bool up) {
  const double decade = std::pow(10.0, std::floor(std::log10(value) + 1e-12));
  const double steps[] = {1.0, 2.0, 5.0, 10.0};
  double below = decade;
  for (const double factor : steps) {
    const double mark = factor * decade;
    if (up && mark >= value * (1.0 - 1e-9)) return mark;
    if (mark <= value * (1.0 + 1e-9)) below = mark;
  }
  return below;
}

std::string format(const char* pattern, int digits, double value) {
  char text[64];
  std::snprintf(text, sizeof text, pattern, digits, value);
  return text;
}

/// A hyphen is too short for a minus.
std::string with_minus(std::string number) {
  if (!number.empty() && number[0] == '-') number.replace(0, 1, "−");
  return number;
}

std::string power_label(int exponent) { return "10^{" + with_minus(std::to_string(exponent)) + "}"; }

std::vector<Tick> linear_ticks(AxisRange range, int most_labels) {
  const double span = range.high - range.low;
  double step = round_step(span / std::max(1, most_labels));
  if (step > 0.5 * span) step = round_step(span / 3.0);
  const double minor = step / (std::fabs(step / round_step(step * 0.3) - 4.0) < 0.1 ? 4.0 : 5.0);
  std::vector<Tick> ticks;
  const auto first = static_cast<long>(std::ceil(range.low / minor - 1e-6));
  const auto last = static_cast<long>(std::floor(range.high / minor + 1e-6));
  const auto per_major = static_cast<long>(std::lround(step / minor));
  for (long i = first; i <= last; ++i) {
    const double value = static_cast<double>(i) * minor;
    const bool major = i % per_major == 0;
    ticks.push_back({value, major ? tick_label(value, step) : "", major});
  }
  return ticks;
}

/// A decade as engineers write it: plain while short, else as a power.
std::string decade_label(int exponent, bool plain) {
  if (!plain) return power_label(exponent);
  return exponent >= 0 ? format("%.*f", 0, std::pow(10.0, exponent))
                       : format("%.*f", -exponent, std::pow(10.0, exponent));
}

std::vector<Tick> log_ticks(AxisRange range, int most_labels) {
  const double low = std::log10(range.low);
  const double high = std::log10(range.high);
  const int first = static_cast<int>(std::floor(low + 1e-9));
  const int last = static_cast<int>(std::floor(high + 1e-9));
  const double decades = high - low;
  const bool plain = low > -3.1 && high < 4.1;
  const int every = std::max(1, static_cast<int>(std::ceil(decades / std::max(1, most_labels))));
  // With few decades the decades alone would leave an axis of one or two numbers.
  const bool label_multiples = decades < 1.7;
  std::vector<Tick> ticks;
  for (int exponent = first; exponent <= last; ++exponent) {
    for (int factor = 1; factor <= 9; ++factor) {
      if (every > 1 && factor > 1) break;
      const double value = factor * std::pow(10.0, exponent);
      if (value < range.low * (1.0 - 1e-9) || value > range.high * (1.0 + 1e-9)) continue;
      Tick tick{value, "", factor == 1};
      const bool close_range = decades < 0.6;
      if (factor == 1) {
        if (exponent % every == 0) tick.label = decade_label(exponent, plain);
      } else if (label_multiples && (close_range || factor == 2 || factor == 5)) {
        tick.label = plain ? format("%.*g", 6, value) : std::to_string(factor) + "×" + power_label(exponent);
      }
      ticks.push_back(tick);
    }
  }
  return ticks;
}

}  // namespace

bool drawable(Scale scale, double value) {
  return std::isfinite(value) && (scale == Scale::kLinear || value > 0.0);
}

std::optional<AxisRange> data_range(Scale scale, const std::vector<double>& values) {
  std::optional<AxisRange> range;
  for (const double value : values) {
    if (!drawable(scale, value)) continue;
    if (!range) range = AxisRange{value, value};
    range->low = std::min(range->low, value);
    range->high = std::max(range->high, value);
  }
  return range;
}

AxisRange axis_range(Scale scale, AxisRange data) {
  if (scale == Scale::kLog) {
    // Whole decades for wide data, and for a single value, which has no width of its own.
    const bool decades = data.high > data.low * 20.0 || data.high < data.low * 1.5;
    if (!decades) return {round_125(data.low, false), round_125(data.high, true)};
    const double low = std::floor(std::log10(data.low) + 1e-9);
    const double high = std::ceil(std::log10(data.high) - 1e-9);
    return {std::pow(10.0, low >= high ? low - 1.0 : low), std::pow(10.0, low >= high ? high + 1.0 : high)};
  }
  double span = data.high - data.low;
  const double size = std::max(std::fabs(data.low), std::fabs(data.high));
  if (span <= 1e-9 * size || span == 0.0) {  // constant, but for rounding
    const double room = size > 0.0 ? 0.1 * size : 1.0;
    return {data.low - room, data.high + room};
  }
  const bool from_zero = data.low >= 0.0 && data.low < 0.35 * data.high;
  if (from_zero) span = data.high;
  const double step = round_step(span / 10.0);
  AxisRange range{from_zero ? 0.0 : std::floor((data.low - 0.02 * span) / step) * step,
                  std::ceil((data.high + 0.03 * span) / step) * step};
  return range;
}

std::vector<Tick> axis_ticks(Scale scale, AxisRange range, int most_labels) {
  if (scale == Scale::kLinear) return linear_ticks(range, most_labels);
  std::vector<Tick> ticks = log_ticks(range, most_labels);
  const auto labelled =
      std::count_if(ticks.begin(), ticks.end(), [](const Tick& t) { return !t.label.empty(); });
  if (labelled >= 2) return ticks;
  // A range between two multiples of a decade: equal steps serve better than none.
  ticks = linear_ticks(range, most_labels);
  ticks.erase(std::remove_if(ticks.begin(), ticks.end(), [](const Tick& t) { return t.value <= 0.0; }),
              ticks.end());
  return ticks;
}

double axis_position(Scale scale, AxisRange range, double value) {
  if (scale == Scale::kLinear) return (value - range.low) / (range.high - range.low);
  return std::log(value / range.low) / std::log(range.high / range.low);
}

std::string tick_label(double value, double step) {
  if (std::fabs(value) < 1e-9 * step) return "0";
  if (step >= 1e5 || step < 0.99e-5) {
    // The factor takes as many digits as neighbours need to differ.
    const int exponent = static_cast<int>(std::floor(std::log10(std::fabs(value)) + 1e-9));
    const int digits = std::max(0, exponent - static_cast<int>(std::floor(std::log10(step) + 1e-9)));
    return with_minus(format("%.*f", digits, value / std::pow(10.0, exponent))) + "×" + power_label(exponent);
  }
  const int decimals = std::max(0, -static_cast<int>(std::floor(std::log10(step) + 1e-9)));
  return with_minus(format("%.*f", decimals, value));
}

}  // namespace creepctl
