// SPDX-License-Identifier: Apache-2.0

// Rows of temperatures: lines between their times, nothing beyond them.

#include "radiometry/thermal/temperature_rows.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "radiometry/thermal/thermal_scene.h"
#include "radiometry/weather/instant.h"
#include "tests/expect_error.h"

namespace radiometry::thermal {
namespace {

const double kStart = heat::instant_of({2026, 6, 21}, 0.0);
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

/// Two facets at 0, 100 and 400 s, the second a sheet whose back is colder by 20 K.
TemperatureRows sheets() {
  TemperatureRows rows{.source = "sheets.npy"};
  rows.append(kStart, std::array{300.0, 310.0}, std::array{kNaN, 290.0});
  rows.append(kStart + 100.0, std::array{302.0, 320.0}, std::array{kNaN, 300.0});
  rows.append(kStart + 400.0, std::array{302.0, 350.0}, std::array{kNaN, 330.0});
  return rows;
}

TEST(TemperatureRows, AreStraightLinesBetweenTheirTimes) {
  const TemperatureRows rows = sheets();
  std::vector<float> kelvin;
  for (const auto& [after_s, second_k] :
       {std::pair{0.0, 310.0F}, {50.0, 315.0F}, {100.0, 320.0F}, {250.0, 335.0F}, {400.0, 350.0F}}) {
    EXPECT_EQ(rows.front_at(1, kStart + after_s), static_cast<double>(second_k));
    rows.sides_at(kStart + after_s, kelvin);
    EXPECT_EQ(kelvin, (std::vector{static_cast<float>(rows.front_at(0, kStart + after_s)), kelvin[0], second_k,
                                   second_k - 20.0F}));
  }
}

TEST(TemperatureRows, AreRefusedBeyondTheirTimes) {
  const TemperatureRows rows = sheets();
  std::vector<float> kelvin;
  for (const double after_s : {-1.0, 401.0}) {
    const std::initializer_list<std::string_view> parts = {"sheets.npy", "2026-06-21T00:00:00Z", "2026-06-21T00:06:40Z",
                                                           "choose a time"};
    expect_refused(parts, [&] { rows.front_at(0, kStart + after_s); });
    expect_refused(parts, [&] { rows.sides_at(kStart + after_s, kelvin); });
  }
  expect_refused({"2026-06-21T00:06:41Z"}, [&] { rows.require(kStart + 401.0); });
}

TEST(TemperatureRows, OfOneRowWithoutATimeHoldAlways) {
  const TemperatureRows rows{.source = "t", .facets = 2, .front_k = {300.0F, 310.0F}};
  for (const double utc_s : {-1e12, 0.0, 1e12}) EXPECT_EQ(rows.front_at(1, utc_s), 310.0);
  EXPECT_FALSE(rows.change());
  EXPECT_FALSE(rows.span_utc_s());
}

// Of a long file the rows about a time are in memory, which are the same numbers.
TEST(TemperatureRows, MayBeginWithALaterRow) {
  const TemperatureRows all = sheets();
  TemperatureRows last = all;
  last.first = 1;
  last.front_k.erase(last.front_k.begin(), last.front_k.begin() + 2);
  last.back_k.erase(last.back_k.begin(), last.back_k.begin() + 2);
  EXPECT_FALSE(last.has(last.place_of(kStart + 99.0)));
  ASSERT_TRUE(last.has(last.place_of(kStart + 101.0)));
  std::vector<float> a, b;
  all.sides_at(kStart + 123.0, a), last.sides_at(kStart + 123.0, b);
  EXPECT_EQ(a, b);
}

TEST(TemperatureRows, ThatAreNotOfTheSceneAreRefused) {
  require_valid(sheets(), 2, "here");
  expect_refused({"here", "6 temperatures", "3 facets"}, [] { require_valid(sheets(), 3, "here"); });
  TemperatureRows rows = sheets();
  rows.utc_s[2] = rows.utc_s[1];
  expect_refused({"here", "rising times"}, [&] { require_valid(rows, 2, "here"); });
}

// Each region by what it has: a schedule, which holds beyond its times, or a table, which does not.
TEST(TemperatureRows, OfRegionsAreThoseThatTheyAreGiven) {
  ThermalScene scene{.name = "three",
                     .region_of = {2, 1, 0},
                     .regions = {{.name = "schedule",
                                  .temperature = heat::make_schedule("s", {kStart, kStart + 10.0}, {300.0, 310.0})},
                                 {.name = "table"},
                                 {.name = "solved", .material = 0}}};
  scene.regions[1].table =
      std::make_shared<const TemperatureRows>(TemperatureRows{.source = "t",
                                                              .facets = 3,
                                                              .utc_s = {kStart, kStart + 10.0},
                                                              .front_k = {0.0F, 280.0F, 0.0F, 0.0F, 270.0F, 0.0F}});
  const TemperatureRows rows = given_rows(scene, kStart + 5.0);
  EXPECT_TRUE(std::isnan(rows.front_k[0]));
  EXPECT_EQ(rows.front_k[1], 275.0F);
  EXPECT_EQ(rows.front_k[2], 305.0F);
  expect_refused({"of t,"}, [&] { given_rows(scene, kStart + 11.0); });
  scene.regions[1] = {.name = "constant", .temperature = heat::constant_schedule(260.0)};
  EXPECT_EQ(given_rows(scene, kStart + 11.0).front_k[2], 310.0F);
}

}  // namespace
}  // namespace radiometry::thermal
