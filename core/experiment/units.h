// Quantities with units, as a job file writes them: "21.7 MPa" -> 21.7e6.
#pragma once

#include <string>
#include <string_view>

#include "absl/status/statusor.h"

namespace creep {

enum class Dimension { kLength, kStress, kDuration, kVelocity, kDensity };

/// "length", "stress", "duration", "velocity", "density".
std::string_view dimension_name(Dimension dimension);

/// "Pa, kPa, MPa, GPa": the units that parse_quantity() takes for the dimension.
std::string allowed_units(Dimension dimension);

/// The value in SI of a number and its unit. The decimal point is shifted before the text becomes binary, so
/// "0.6 um" is the very double 0.6e-6. A year (y) is 365.25 d.
/// Error: InvalidArgument; the message says which dimension is wanted, lists its units and guesses at slips.
absl::StatusOr<double> parse_quantity(std::string_view text, Dimension dimension);

/// The value [SI] with the unit that reads best: 172800 s -> "2 d".
std::string format_quantity(double value, Dimension dimension);

}  // namespace creep
