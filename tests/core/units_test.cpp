#include "core/experiment/units.h"

#include <gtest/gtest.h>

namespace creep {
namespace {

std::string error_of(std::string_view text, Dimension dimension) {
  return std::string(parse_quantity(text, dimension).status().message());
}

TEST(Units, every_unit_gives_the_double_that_the_si_literal_gives) {
  // Exact: the decimal point is shifted in the text, so nothing is rounded twice.
  EXPECT_EQ(*parse_quantity("21.7 MPa", Dimension::kStress), 21.7e6);
  EXPECT_EQ(*parse_quantity("100 kPa", Dimension::kStress), 100e3);
  EXPECT_EQ(*parse_quantity("3.75 GPa", Dimension::kStress), 3.75e9);
  EXPECT_EQ(*parse_quantity("7 Pa", Dimension::kStress), 7.0);
  EXPECT_EQ(*parse_quantity("0.6 um", Dimension::kLength), 0.6e-6);
  EXPECT_EQ(*parse_quantity("4 mm", Dimension::kLength), 4e-3);
  EXPECT_EQ(*parse_quantity("0.1155 mm", Dimension::kLength), 0.1155e-3);
  EXPECT_EQ(*parse_quantity("3 nm", Dimension::kLength), 3e-9);
  EXPECT_EQ(*parse_quantity("1.5 cm", Dimension::kLength), 1.5e-2);
  EXPECT_EQ(*parse_quantity("2 m", Dimension::kLength), 2.0);
  EXPECT_EQ(*parse_quantity("0.1 m/s", Dimension::kVelocity), 0.1);
  EXPECT_EQ(*parse_quantity("3 mm/s", Dimension::kVelocity), 3e-3);
  EXPECT_EQ(*parse_quantity("3 um/s", Dimension::kVelocity), 3e-6);
  EXPECT_EQ(*parse_quantity("2650 kg/m3", Dimension::kDensity), 2650.0);
  EXPECT_EQ(*parse_quantity("2.65 g/cm3", Dimension::kDensity), 2650.0);
}

TEST(Units, durations_go_from_microseconds_to_years) {
  EXPECT_EQ(*parse_quantity("5 us", Dimension::kDuration), 5e-6);
  EXPECT_EQ(*parse_quantity("5 ms", Dimension::kDuration), 5e-3);
  EXPECT_EQ(*parse_quantity("5 s", Dimension::kDuration), 5.0);
  EXPECT_EQ(*parse_quantity("10 min", Dimension::kDuration), 600.0);
  EXPECT_EQ(*parse_quantity("1.5 h", Dimension::kDuration), 5400.0);
  EXPECT_EQ(*parse_quantity("2 d", Dimension::kDuration), 172800.0);
  EXPECT_EQ(*parse_quantity("1 y", Dimension::kDuration), 31557600.0);
}

TEST(Units, spaces_signs_exponents_and_the_micro_sign_are_taken) {
  EXPECT_EQ(*parse_quantity("  21.7MPa ", Dimension::kStress), 21.7e6);
  EXPECT_EQ(*parse_quantity("+2.17e1 MPa", Dimension::kStress), 21.7e6);
  EXPECT_EQ(*parse_quantity("-1 kPa", Dimension::kStress), -1e3);
  EXPECT_EQ(*parse_quantity("1E-3 m", Dimension::kLength), 1e-3);
  EXPECT_EQ(*parse_quantity(".5 mm", Dimension::kLength), 0.5e-3);
  EXPECT_EQ(*parse_quantity("0.6 \u00B5m", Dimension::kLength), 0.6e-6);  // micro sign
  EXPECT_EQ(*parse_quantity("0.6 \u03BCm", Dimension::kLength), 0.6e-6);  // Greek mu
  EXPECT_EQ(*parse_quantity("2650 kg/m\u00B3", Dimension::kDensity), 2650.0);
}

TEST(Units, a_slip_in_a_unit_gets_a_guess) {
  EXPECT_EQ(error_of("21.7 Mpa", Dimension::kStress),
            "unknown unit \"Mpa\" for a stress; did you mean \"MPa\"? (units: Pa, kPa, MPa, GPa)");
  EXPECT_NE(error_of("100 KPa", Dimension::kStress).find("did you mean \"kPa\"?"), std::string::npos);
  EXPECT_NE(error_of("2 days", Dimension::kDuration).find("did you mean \"d\"?"), std::string::npos);
  EXPECT_NE(error_of("2 hours", Dimension::kDuration).find("did you mean \"h\"?"), std::string::npos);
}

TEST(Units, another_dimension_is_named) {
  const std::string message = error_of("4 mm", Dimension::kStress);
  EXPECT_NE(message.find("\"mm\" is a unit of length"), std::string::npos) << message;
  EXPECT_NE(message.find("a stress with its unit is wanted"), std::string::npos) << message;
}

TEST(Units, what_is_no_quantity_is_refused) {
  for (const std::string_view text : {"", " ", "MPa", "nan MPa", "inf MPa", "-inf MPa", "1e MPa", "1e999 MPa",
                                      "- MPa", "1e99999999999 MPa", "0x10 MPa", "1_000 Pa", "21,7 MPa",
                                      "1 MPa MPa", "1", "e5 Pa", "1.2.3 Pa", "1 MPa\n", "1e-99999 Pa"}) {
    EXPECT_FALSE(parse_quantity(text, Dimension::kStress).ok()) << text;
  }
  EXPECT_NE(error_of("21,7 MPa", Dimension::kStress).find("write a decimal point"), std::string::npos);
  EXPECT_NE(error_of("21.7", Dimension::kStress).find("has no unit"), std::string::npos);
}

TEST(Units, a_quantity_is_shown_in_the_unit_that_reads_best) {
  EXPECT_EQ(format_quantity(172800.0, Dimension::kDuration), "2 d");
  EXPECT_EQ(format_quantity(1e-3, Dimension::kDuration), "1 ms");
  EXPECT_EQ(format_quantity(21.7e6, Dimension::kStress), "21.7 MPa");
  EXPECT_EQ(format_quantity(0.0, Dimension::kStress), "0 Pa");
  EXPECT_EQ(format_quantity(0.21e-3, Dimension::kLength), "210 um");
  EXPECT_EQ(format_quantity(2650.0, Dimension::kDensity), "2650 kg/m3");
  EXPECT_EQ(format_quantity(-5e3, Dimension::kStress), "-5 kPa");
}

}  // namespace
}  // namespace creep
