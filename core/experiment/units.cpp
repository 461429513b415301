#include "core/experiment/units.h"

#include <array>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <optional>
#include <span>
#include <vector>

#include "core/arithmetic/check.h"
#include "core/experiment/wording.h"

namespace creep {
namespace {

/// One unit is `multiplier` x 10^`exponent` SI units.
struct Unit {
  std::string_view name;
  Dimension dimension;
  int exponent;
  double multiplier;
};

// By dimension, ascending: format_quantity() takes the last that is not larger than the value.
constexpr std::array kUnits = {
    Unit{"nm", Dimension::kLength, -9, 1.0},     Unit{"um", Dimension::kLength, -6, 1.0},
    Unit{"mm", Dimension::kLength, -3, 1.0},     Unit{"cm", Dimension::kLength, -2, 1.0},
    Unit{"m", Dimension::kLength, 0, 1.0},       Unit{"Pa", Dimension::kStress, 0, 1.0},
    Unit{"kPa", Dimension::kStress, 3, 1.0},     Unit{"MPa", Dimension::kStress, 6, 1.0},
    Unit{"GPa", Dimension::kStress, 9, 1.0},     Unit{"us", Dimension::kDuration, -6, 1.0},
    Unit{"ms", Dimension::kDuration, -3, 1.0},   Unit{"s", Dimension::kDuration, 0, 1.0},
    Unit{"min", Dimension::kDuration, 0, 60.0},  Unit{"h", Dimension::kDuration, 0, 3600.0},
    Unit{"d", Dimension::kDuration, 0, 86400.0}, Unit{"y", Dimension::kDuration, 0, 31557600.0},
    Unit{"um/s", Dimension::kVelocity, -6, 1.0}, Unit{"mm/s", Dimension::kVelocity, -3, 1.0},
    Unit{"m/s", Dimension::kVelocity, 0, 1.0},   Unit{"kg/m3", Dimension::kDensity, 0, 1.0},
    Unit{"g/cm3", Dimension::kDensity, 3, 1.0},
};

/// Other spellings that are taken as they stand.
struct Alias {
  std::string_view spelling;
  std::string_view name;
};
constexpr std::array kAliases = {
    Alias{"\u00B5m", "um"},       Alias{"\u03BCm", "um"},       Alias{"\u00B5s", "us"},
    Alias{"\u03BCs", "us"},       Alias{"\u00B5m/s", "um/s"},   Alias{"\u03BCm/s", "um/s"},
    Alias{"kg/m^3", "kg/m3"},     Alias{"kg/m\u00B3", "kg/m3"}, Alias{"g/cm^3", "g/cm3"},
    Alias{"g/cm\u00B3", "g/cm3"},
};

/// Words that are refused, with the unit that was meant.
constexpr std::array kWordsForUnits = {
    Alias{"sec", "s"},       Alias{"second", "s"},  Alias{"seconds", "s"},  Alias{"minute", "min"},
    Alias{"minutes", "min"}, Alias{"hr", "h"},      Alias{"hour", "h"},     Alias{"hours", "h"},
    Alias{"day", "d"},       Alias{"days", "d"},    Alias{"year", "y"},     Alias{"years", "y"},
    Alias{"a", "y"},         Alias{"micron", "um"}, Alias{"microns", "um"}, Alias{"pascal", "Pa"},
};

std::vector<std::string_view> unit_names(Dimension dimension) {
  std::vector<std::string_view> names;
  for (const Unit& unit : kUnits) {
    if (unit.dimension == dimension) names.push_back(unit.name);
  }
  return names;
}

const Unit* find_unit(std::string_view name) {
  for (const Alias& alias : kAliases) {
    if (alias.spelling == name) name = alias.name;
  }
  for (const Unit& unit : kUnits) {
    if (unit.name == name) return &unit;
  }
  return nullptr;
}

std::string_view trimmed(std::string_view text) {
  while (!text.empty() && (text.front() == ' ' || text.front() == '\t')) text.remove_prefix(1);
  while (!text.empty() && (text.back() == ' ' || text.back() == '\t')) text.remove_suffix(1);
  return text;
}

bool is_digit(char letter) { return letter >= '0' && letter <= '9'; }

/// A decimal number split so that its exponent can be shifted: mantissa x 10^exponent.
struct Decimal {
  std::string_view mantissa;
  int exponent = 0;
  std::string_view rest;  ///< what follows, trimmed
};

std::optional<Decimal> split_decimal(std::string_view text) {
  std::size_t end = 0;
  std::size_t digits = 0;
  bool point = false;
  if (end < text.size() && (text[end] == '-' || text[end] == '+')) ++end;
  for (; end < text.size() && (is_digit(text[end]) || (text[end] == '.' && !point)); ++end) {
    if (text[end] == '.')
      point = true;
    else
      ++digits;
  }
  if (digits == 0) return std::nullopt;
  Decimal decimal{.mantissa = text.substr(0, end), .exponent = 0, .rest = {}};
  if (decimal.mantissa.front() == '+') decimal.mantissa.remove_prefix(1);  // from_chars takes no plus
  if (end < text.size() && (text[end] == 'e' || text[end] == 'E')) {
    std::size_t begin = end + 1;
    if (begin < text.size() && text[begin] == '+') ++begin;
    const auto [stop, error] =
        std::from_chars(text.data() + begin, text.data() + text.size(), decimal.exponent);
    if (error == std::errc::result_out_of_range) return std::nullopt;
    if (error == std::errc()) end = static_cast<std::size_t>(stop - text.data());
  }
  if (decimal.exponent > 1000 || decimal.exponent < -1000) return std::nullopt;
  decimal.rest = trimmed(text.substr(end));
  return decimal;
}

std::string_view example_of(Dimension dimension) {
  switch (dimension) {
    case Dimension::kLength:
      return "\"4 mm\"";
    case Dimension::kStress:
      return "\"21.7 MPa\"";
    case Dimension::kDuration:
      return "\"2 d\"";
    case Dimension::kVelocity:
      return "\"0.1 m/s\"";
    case Dimension::kDensity:
      return "\"2650 kg/m3\"";
  }
  return "";
}

std::string wanted(Dimension dimension) {
  return "a " + std::string(dimension_name(dimension)) + " with its unit is wanted, like " +
         std::string(example_of(dimension)) + " (units: " + allowed_units(dimension) + ")";
}

absl::Status wrong_unit(std::string_view name, Dimension dimension) {
  if (const Unit* other = find_unit(name)) {
    return absl::InvalidArgumentError(quoted(name) + " is a unit of " +
                                      std::string(dimension_name(other->dimension)) + "; " +
                                      wanted(dimension));
  }
  const std::vector<std::string_view> names = unit_names(dimension);
  std::optional<std::string_view> guess;
  for (const Alias& word : kWordsForUnits) {
    if (word.spelling == name && find_unit(word.name)->dimension == dimension) guess = word.name;
  }
  if (!guess) guess = closest(name, names);
  return absl::InvalidArgumentError(
      "unknown unit " + quoted(name) + " for a " + std::string(dimension_name(dimension)) +
      (guess ? "; did you mean " + quoted(*guess) + "?" : "") + " (units: " + listed(names) + ")");
}

}  // namespace

std::string_view dimension_name(Dimension dimension) {
  switch (dimension) {
    case Dimension::kLength:
      return "length";
    case Dimension::kStress:
      return "stress";
    case Dimension::kDuration:
      return "duration";
    case Dimension::kVelocity:
      return "velocity";
    case Dimension::kDensity:
      return "density";
  }
  return "";
}

std::string allowed_units(Dimension dimension) { return listed(unit_names(dimension)); }

absl::StatusOr<double> parse_quantity(std::string_view text, Dimension dimension) {
  const std::optional<Decimal> decimal = split_decimal(trimmed(text));
  if (!decimal) return absl::InvalidArgumentError(quoted(text) + " is not a quantity; " + wanted(dimension));
  if (decimal->rest.empty()) {
    return absl::InvalidArgumentError(quoted(text) + " has no unit; " + wanted(dimension));
  }
  if (decimal->rest.front() == ',' && decimal->rest.size() > 1 && is_digit(decimal->rest[1])) {
    return absl::InvalidArgumentError(quoted(text) + " has a comma; write a decimal point; " +
                                      wanted(dimension));
  }
  const Unit* unit = find_unit(decimal->rest);
  if (unit == nullptr || unit->dimension != dimension) return wrong_unit(decimal->rest, dimension);

  const std::string shifted =
      std::string(decimal->mantissa) + "e" + std::to_string(decimal->exponent + unit->exponent);
  double value = 0.0;
  const auto [stop, error] = std::from_chars(shifted.data(), shifted.data() + shifted.size(), value);
  if (error != std::errc() || !std::isfinite(value * unit->multiplier)) {
    return absl::InvalidArgumentError(quoted(text) + " is beyond what a double can hold; " +
                                      wanted(dimension));
  }
  return value * unit->multiplier + 0.0;  // no negative zero
}

std::string format_quantity(double value, Dimension dimension) {
  const Unit* best = nullptr;
  for (const Unit& unit : kUnits) {
    if (unit.dimension != dimension || unit.name == "cm" || unit.name == "g/cm3") continue;
    const double size = unit.multiplier * std::pow(10.0, unit.exponent);
    // A hair of slack, so that 1e-3 s is 1 ms although neither is exact.
    if (best == nullptr || std::abs(value) >= size * (1.0 - 1e-12)) best = &unit;
  }
  if (value == 0.0) best = find_unit(unit_names(dimension).front());
  CREEP_CHECK(best != nullptr, "a dimension without a unit");
  std::array<char, 64> buffer{};
  std::snprintf(buffer.data(), buffer.size(), "%.6g",
                value / best->multiplier / std::pow(10.0, best->exponent));
  return std::string(buffer.data()) + " " + std::string(best->name);
}

}  // namespace creep
