// SPDX-License-Identifier: Apache-2.0
#include "mtf/units.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "mtf/error.h"
#include "tests/expect_error.h"
#include "tests/mtf/conformance.h"

namespace mtf::test {
namespace {

std::string refusal(const char* text, Dimension expected) {
  return message_of<mtf::UsageError>([&] { parse_quantity(text, expected); });
}

TEST(Units, quantities_are_a_number_and_a_unit) {
  for (const char* text :
       {"15 um", "15um", " 15   um ", "+15 um", "1.5e1 um", "\t15\tum", "15.0 \xC2\xB5m", "15 \xCE\xBCm"}) {
    const Quantity q = parse_quantity(text, Dimension::length);
    EXPECT_EQ(q.value, 15.0) << text;
    EXPECT_EQ(q.unit->name, "um") << text;
  }
  EXPECT_EQ(parse_quantity("-3 deg", Dimension::angle).value, -3.0);
  EXPECT_EQ(parse_quantity("5e-324 um", Dimension::length).value, 5e-324);
  for (const char* text : {"2 um", "8 urad", "0.5 px"})
    EXPECT_NO_THROW(parse_quantity(text, Dimension::extent)) << text;
  EXPECT_EQ(parse_quantity("1 \xC2\xB5rad/s", Dimension::rate).unit, find_unit("urad/s"));
}

TEST(Units, degrees_celsius_become_kelvin) {
  for (const char* text : {"14.85 degC", "14.85degC", "14.85 \u00b0C"}) {
    const Quantity t = parse_quantity(text, Dimension::temperature);
    EXPECT_DOUBLE_EQ(t.value, 288.0) << text;
    EXPECT_EQ(t.unit->name, "K");
  }
  EXPECT_NEAR(parse_quantity("-40 degC", Dimension::temperature).value, 233.15, 1e-12);
  EXPECT_THROW(parse_quantity("20 degC", Dimension::length), UsageError);
  EXPECT_THROW(parse_quantity("2 degC", Dimension::temperature_difference), UsageError);
  EXPECT_EQ(parse_quantity("2 K", Dimension::temperature_difference).value, 2.0);
  expect_says(refusal("27 degc", Dimension::temperature), {"did you mean \"degC\""});
}

TEST(Units, whatever_is_not_is_refused) {
  const auto mentions = [](const char* text, const char* part) {
    const std::string message = refusal(text, Dimension::length);
    expect_says(message, {part, "a length such as"});
    EXPECT_FALSE(says(message, "\n")) << message;
  };
  mentions("15 furlong", "unknown unit \"furlong\"");
  mentions("15", "no unit");
  mentions("um", "no number");
  mentions("", "no number");
  mentions("1e999 um", "out of range");
  mentions("nan um", "not finite");
  mentions("inf um", "not finite");
  mentions("+-5 um", "no number");
  mentions("--5 um", "no number");
  mentions("15 um um", "unknown unit");
  mentions("15 Um", "unknown unit \"Um\"");  // case matters: mrad is not Mrad
  mentions("15 umm", "did you mean \"um\"?");
  mentions("15 microns", "unknown unit");
  for (const char* other : {"15 kg", "15 kgs", "15 Um", "15 mil"})
    EXPECT_FALSE(says(refusal(other, Dimension::length), "did you mean")) << other;
  mentions("8 urad", "does not fit");
  mentions("0x10 um", "unknown unit");
  mentions("15,5 um", "unknown unit");
  EXPECT_NE(refusal("3 s", Dimension::extent), "");
  EXPECT_NE(refusal("3 Hz", Dimension::frequency), "");
  EXPECT_NE(refusal("3 cy/mm", Dimension::temporal), "");
  EXPECT_NE(refusal("3 um", Dimension::cutoff), "");
  EXPECT_NE(refusal("3 cy/mm", Dimension::length), "");
  mentions("27 degC", "unknown unit");
  EXPECT_NE(refusal("3 e-", Dimension::current), "");
}

TEST(Units, conversion_is_exact_where_the_decimal_is) {
  const auto um = [](const char* text) { return convert(parse_quantity(text, Dimension::length), "um"); };
  EXPECT_EQ(um("100 mm"), 100000.0);
  EXPECT_EQ(um("3400 nm"), 3.4);
  EXPECT_EQ(um("0.3 mm"), 300.0);
  EXPECT_EQ(um("2 in"), 50800.0);
  EXPECT_EQ(um("5 km"), 5e9);
  const auto mm = [](const char* text) { return convert(parse_quantity(text, Dimension::length), "mm"); };
  EXPECT_EQ(mm("1 um"), 0.001);
  EXPECT_EQ(mm("7 nm"), 7e-6);
  EXPECT_EQ(mm("0.1 m"), 100.0);
  EXPECT_EQ(convert(parse_quantity("10 ms", Dimension::time), "s"), 0.01);
  EXPECT_EQ(convert(parse_quantity("20 mrad/s", Dimension::rate), "urad/s"), 20000.0);
  EXPECT_EQ(convert(parse_quantity("10.5 MHz", Dimension::temporal), "Hz"), 10.5e6);
  EXPECT_EQ(convert(parse_quantity("3 GHz", Dimension::cutoff), "kHz"), 3e6);
  EXPECT_NEAR(convert(parse_quantity("10 fL", Dimension::luminance), "cd/m^2"), 34.262591, 5e-7);
  EXPECT_EQ(convert(parse_quantity("60 mm/s^2", Dimension::acceleration), "um/s^2"), 60000.0);
  EXPECT_EQ(convert(parse_quantity("0.6 rad/s^2", Dimension::angular_acceleration), "urad/s^2"), 6e5);
  EXPECT_EQ(convert(parse_quantity("7 Me-", Dimension::electrons), "e-"), 7e6);
  EXPECT_EQ(convert(parse_quantity("25 mK", Dimension::temperature), "K"), 0.025);
  EXPECT_DOUBLE_EQ(convert(parse_quantity("100 fF", Dimension::capacitance), "F"), 1e-13);
  EXPECT_NEAR(convert(parse_quantity("1 pA", Dimension::current), "e-/s"), 6241509.0744607631, 1e-9);  // 1e-12 / q
  EXPECT_DOUBLE_EQ(convert(parse_quantity("180 deg", Dimension::angle), "rad"), std::numbers::pi);
  EXPECT_DOUBLE_EQ(convert(parse_quantity("60 arcmin", Dimension::angle), "deg"), 1.0);
  EXPECT_DOUBLE_EQ(convert(parse_quantity("3600 arcsec", Dimension::angle), "deg"), 1.0);
}

TEST(Units, a_unit_converts_to_itself_and_back) {
  Random random(3);
  for (const char* from : {"nm", "um", "mm", "cm", "m", "km", "in"})
    for (const char* to : {"nm", "um", "mm", "m"}) {
      const double value = random.decades(1e-9, 1e9);
      const double there = convert({value, find_unit(from)}, to);
      EXPECT_NEAR(convert({there, find_unit(to)}, from) / value, 1.0, 4.5e-16) << from << to;
      EXPECT_EQ(convert({value, find_unit(from)}, from), value);
    }
}

TEST(Units, shortest_text_reads_back) {
  EXPECT_EQ(format_double(0.1), "0.1");
  EXPECT_EQ(format_double(15.0), "15");
  EXPECT_EQ(format_double(1e300), "1e+300");
  Random random(4);
  for (int i = 0; i < 2000; ++i) {
    const double value = random.decades(1e-300, 1e300);
    EXPECT_EQ(std::strtod(format_double(value).c_str(), nullptr), value);
  }
}

TEST(Units, nearest_word) {
  const std::vector<std::string> words{"diffraction", "jitter", "footprint"};
  EXPECT_EQ(nearest("jiter", words), "jitter");
  EXPECT_EQ(nearest("fotoprint", words), "footprint");
  EXPECT_FALSE(nearest("zebra", words).has_value());
  EXPECT_EQ(edit_distance("ab", "ba"), 1);
  EXPECT_EQ(edit_distance("", "abc"), 3);
  EXPECT_EQ(edit_distance("kitten", "sitting"), 3);
  EXPECT_LE(edit_distance(std::string(100000, 'a'), std::string(100000, 'b')), 64);
}

}  // namespace
}  // namespace mtf::test
