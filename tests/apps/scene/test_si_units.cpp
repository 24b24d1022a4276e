// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <numbers>

#include "apps/scene/weather/si_units.h"
#include "tests/apps/scene/weather_texts.h"
#include "tests/expect_error.h"

namespace apps::scene {
namespace {

double si(std::string_view text, std::string_view unit) { return parse_si(text, unit, "1 " + std::string(unit)); }

TEST(SiUnits, ReadsProductsOfPowers) {
  EXPECT_DOUBLE_EQ(si("45 W/m/K", "W/m/K"), 45.0);
  EXPECT_DOUBLE_EQ(si("45 W/(m K)", "W/m/K"), 45.0);
  EXPECT_DOUBLE_EQ(si("45W m^-1 K^-1", "W/m/K"), 45.0);
  EXPECT_DOUBLE_EQ(si("45 W.m-1.K-1", "W/m/K"), 45.0);
  EXPECT_DOUBLE_EQ(si("7.8 g/cm3", "kg/m3"), 7800.0);
  EXPECT_DOUBLE_EQ(si("0.48 kJ/kg/K", "J/kg/K"), 480.0);
  EXPECT_DOUBLE_EQ(si("20 mm", "m"), 0.02);
  EXPECT_DOUBLE_EQ(si("10 min", "s"), 600.0);
  EXPECT_DOUBLE_EQ(si("36 km/h", "m/s"), 10.0);
  EXPECT_DOUBLE_EQ(si("1013.25 hPa", "Pa"), 101325.0);
  EXPECT_DOUBLE_EQ(si("1 W h/m2", "J/m2"), 3600.0);
  EXPECT_DOUBLE_EQ(si("3.8 W/m2/K/(m/s)", "J/m3/K"), 3.8);
  EXPECT_DOUBLE_EQ(si("180 deg", "rad"), std::numbers::pi);
  EXPECT_DOUBLE_EQ(si("20 degC", "K"), 293.15);
  EXPECT_DOUBLE_EQ(si("-5\u00b0C", "K"), 268.15);
  EXPECT_DOUBLE_EQ(si("+0.7", ""), 0.7);
  EXPECT_DOUBLE_EQ(si("70 %", ""), 0.7);
}

TEST(SiUnits, RefusesWhatDoesNotFitAndSaysHow) {
  const auto refusal = [](std::string_view text, std::string_view unit) { return message_of([&] { si(text, unit); }); };
  expect_says(refusal("45", "W/m/K"), {"no unit", "\"1 W/m/K\""});
  expect_says(refusal("45 W/m", "W/m/K"), {"does not fit"});
  expect_says(refusal("45 watts", "W"), {"unknown unit \"watts\""});
  expect_says(refusal("nan m", "m"), {"not finite"});
  expect_says(refusal("1e999 m", "m"), {"out of range"});
  expect_says(refusal("1e308 km", "m"), {"out of range"});
  expect_says(refusal("", "m"), {"no number"});
  expect_says(refusal("m", "m"), {"no number"});
  expect_says(refusal("20 degC", "W"), {"does not fit"});
  for (const char* text :
       {"W//m", "W/", "/", "(m", "m)", "W/(m", "()", "((((((m))))))", "degC/m", "m^", "m^x", "1 m", "m 2"})
    EXPECT_FALSE(parse_unit(text)) << text;
  EXPECT_FALSE(parse_unit(std::string(100000, '(')));
}

}  // namespace
}  // namespace apps::scene
