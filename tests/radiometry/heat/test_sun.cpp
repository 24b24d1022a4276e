// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "mtf/error.h"
#include "radiometry/weather/instant.h"
#include "radiometry/weather/sun.h"

namespace radiometry::heat {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;

Place place_of(double longitude_deg, double latitude_deg, double altitude_m = 0.0) {
  return {latitude_deg * kDegree, longitude_deg * kDegree, altitude_m};
}

double utc(std::string_view text) {
  InstantError error;
  return parse_instant(text, error).value();
}

// ERFA with UT1 = UTC, through its own chain of routines (atco13 without air); printed to 1e-5 deg.
TEST(Sun, KeepsTheReferenceDirections) {
  struct Case {
    const char* time;
    double longitude_deg, latitude_deg, zenith_deg, azimuth_deg;
  };
  for (const Case& c : {Case{"2026-06-21T12:00Z", 8.0, 49.0, 26.24681, 195.80978},
                        Case{"2026-12-21T08:00Z", 8.0, 49.0, 85.72534, 133.94500},
                        Case{"2026-03-20T18:00Z", -104.99, 39.74, 42.55824, 154.65166},
                        Case{"2026-09-01T03:00Z", 151.2, -33.87, 44.87792, 337.01345},
                        Case{"2026-07-01T00:00Z", 25.0, 70.0, 85.31557, 22.09083},
                        Case{"1990-01-01T12:00Z", 0.0, 0.0, 23.01881, 177.92386}}) {
    const SunPosition sun = sun_position(utc(c.time), place_of(c.longitude_deg, c.latitude_deg));
    EXPECT_NEAR(sun.zenith_rad / kDegree, c.zenith_deg, 2e-5) << c.time;
    EXPECT_NEAR(sun.azimuth_rad / kDegree, c.azimuth_deg, 2e-5) << c.time;
  }
  // Distances from the centre of the earth; the observer is up to 4.3e-5 au nearer.
  EXPECT_NEAR(sun_position(utc("2026-06-21T12:00Z"), place_of(8.0, 49.0)).distance_au, 1.016203 - 3.8e-5, 1e-6);
  EXPECT_NEAR(sun_position(utc("2026-12-21T08:00Z"), place_of(8.0, 49.0)).distance_au, 0.983770 - 0.3e-5, 1e-6);
}

// Reda and Andreas, "Solar Position Algorithm for Solar Radiation Applications", NREL/TP-560-34302 (2008), appendix:
// 50.11162 deg and 194.34024 deg with a refraction of its own; ERFA has 50.11234 and 194.34015.
TEST(Sun, IsThatOfThePublishedExample) {
  const Place place = place_of(-105.1786, 39.742476, 1830.14);
  const double time = utc("2003-10-17T12:30:30-07:00");
  const SunPosition seen = sun_position(time, place, {.pressure_pa = 82000.0, .temperature_k = 284.15});
  EXPECT_NEAR(seen.zenith_rad / kDegree, 50.11234, 2e-5);
  EXPECT_NEAR(seen.azimuth_rad / kDegree, 194.34015, 2e-5);
  EXPECT_NEAR(seen.zenith_rad / kDegree, 50.11162, 1e-3);
  EXPECT_NEAR(seen.azimuth_rad / kDegree, 194.34024, 1e-3);
  EXPECT_GT(sun_position(time, place).zenith_rad, seen.zenith_rad) << "air lifts the sun";
  EXPECT_NEAR(sun_position(time, place, {.pressure_pa = 0.0}).zenith_rad, sun_position(time, place).zenith_rad, 1e-12);
}

// Low-precision formulas of the Astronomical Almanac (0.01 deg between 1950 and 2050), another way to the direction.
std::array<double, 3> almanac_direction(double utc_s, const Place& place) {
  const double n = utc_s / kDay_s - 10957.5;  // days from J2000
  const double mean_longitude = 280.460 + 0.9856474 * n, anomaly = (357.528 + 0.9856003 * n) * kDegree;
  const double longitude = (mean_longitude + 1.915 * std::sin(anomaly) + 0.020 * std::sin(2.0 * anomaly)) * kDegree;
  const double obliquity = (23.439 - 4e-7 * n) * kDegree;
  const double ascension = std::atan2(std::cos(obliquity) * std::sin(longitude), std::cos(longitude));
  const double declination = std::asin(std::sin(obliquity) * std::sin(longitude));
  const double sidereal = (280.46062 + 360.98564737 * n) * kDegree + place.longitude_rad;
  const double hour = sidereal - ascension;
  const double sp = std::sin(place.latitude_rad), cp = std::cos(place.latitude_rad);
  return {-std::cos(declination) * std::sin(hour),
          std::sin(declination) * cp - std::cos(declination) * std::cos(hour) * sp,
          std::sin(declination) * sp + std::cos(declination) * std::cos(hour) * cp};
}

TEST(Sun, FollowsTheAlmanacFormulaFrom1900To2100) {
  std::mt19937_64 random(2);
  std::uniform_real_distribution<double> time(instant_of({1900, 1, 1}), instant_of({2100, 12, 31}));
  std::uniform_real_distribution<double> longitude(-180.0, 180.0), latitude(-90.0, 90.0);
  double worst = 0.0;
  for (int i = 0; i < 2000; ++i) {
    const double t = time(random);
    const Place place = place_of(longitude(random), latitude(random));
    const SunPosition sun = sun_position(t, place);
    const auto other = almanac_direction(t, place);
    const double cross = std::hypot(sun.direction[1] * other[2] - sun.direction[2] * other[1],
                                    sun.direction[2] * other[0] - sun.direction[0] * other[2],
                                    sun.direction[0] * other[1] - sun.direction[1] * other[0]);
    worst = std::max(worst, std::asin(cross) / kDegree);
    ASSERT_NEAR(std::hypot(sun.direction[0], sun.direction[1], sun.direction[2]), 1.0, 1e-12);
    ASSERT_NEAR(sun.direction[2], std::cos(sun.zenith_rad), 1e-12);
    ASSERT_NEAR(sun.direction[0], std::sin(sun.zenith_rad) * std::sin(sun.azimuth_rad), 1e-12);
    ASSERT_GT(sun.distance_au, 0.982);
    ASSERT_LT(sun.distance_au, 1.018);
  }
  EXPECT_LT(worst, 0.03);
}

TEST(Sun, MovesSmoothlyAcrossLeapDaysAndLeapSeconds) {
  const Place place = place_of(8.0, 49.0);
  for (const char* midnight : {"2024-02-29T00:00Z", "2024-03-01T00:00Z", "2017-01-01T00:00Z", "1972-01-01T00:00Z",
                               "1900-03-01T00:00Z", "2000-02-29T00:00Z", "2100-03-01T00:00Z"}) {
    const double t = utc(midnight);
    double before = sun_position(t - 2.0, place).direction[0];
    for (double dt = -1.0; dt <= 2.0; ++dt) {
      const double now = sun_position(t + dt, place).direction[0];
      EXPECT_LT(std::abs(now - before), 8e-5) << midnight;  // one second of rotation is 7.3e-5 rad
      before = now;
    }
  }
}

// Twelve o'clock is when the azimuth at any latitude passes south; and the equation of time of Meeus, Astronomical
// Algorithms, example 28.b: 13 min 42.7 s on 1992 October 13 at 0 h of dynamical time, 59 s before UTC.
TEST(Sun, KeepsSolarTime) {
  const Place place = place_of(-105.92, 37.70);
  for (const char* noon : {"2026-02-11T19:00Z", "2026-06-21T19:00Z", "2026-11-03T19:00Z"}) {
    const double t = utc(noon), ahead_s = 3600.0 * (solar_time_h(t, place.longitude_rad) - 12.0);
    EXPECT_NEAR(sun_position(t - ahead_s, place).azimuth_rad, std::numbers::pi, 1e-4) << noon;
  }
  EXPECT_NEAR(3600.0 * solar_time_h(utc("1992-10-12T23:59:01Z"), 0.0), 13.0 * 60.0 + 42.7 - 59.0, 1.5);
  EXPECT_NEAR(solar_time_h(utc("1992-10-13T00:00Z"), place.longitude_rad), 24.0 - 105.92 / 15.0 + 823.0 / 3600.0, 1e-3);
}

TEST(Sun, RisesAndSetsAtTheHorizon) {
  const Place place = place_of(-105.92, 37.70, 2317.0);
  const double begin = utc("2016-01-01T07:00Z");
  const auto crossings = sun_crossings(place, begin, begin + 2.0 * kDay_s);
  ASSERT_EQ(crossings.size(), 4u);
  for (std::size_t i = 0; i < crossings.size(); ++i) {
    EXPECT_EQ(crossings[i].rises, i % 2 == 0);
    // 0.01 s of the sun's motion.
    EXPECT_NEAR(sun_position(crossings[i].utc_s, place).zenith_rad, std::numbers::pi / 2, 7e-7);
    EXPECT_GT(crossings[i].utc_s, i > 0 ? crossings[i - 1].utc_s : begin);
  }
  // Refraction and the sun's radius make the day of almanacs longer; the other formula has the sun there, too.
  const auto almanac = sun_crossings(place, begin, begin + kDay_s, 90.833 * kDegree);
  ASSERT_EQ(almanac.size(), 2u);
  EXPECT_LT(almanac[0].utc_s, crossings[0].utc_s);
  EXPECT_GT(almanac[1].utc_s, crossings[1].utc_s);
  for (const SunCrossing& crossing : almanac)
    EXPECT_NEAR(almanac_direction(crossing.utc_s, place)[2], std::cos(90.833 * kDegree), 0.02 * kDegree);
}

TEST(Sun, DoesNotCrossTheHorizonInPolarDayAndNight) {
  const Place place = place_of(25.0, 70.0);
  for (const char* day : {"2026-07-01T00:00Z", "2026-12-21T00:00Z"}) {
    const double begin = utc(day);
    EXPECT_TRUE(sun_crossings(place, begin, begin + 3.0 * kDay_s).empty()) << day;
  }
  const double summer = utc("2026-07-01T00:00Z");
  for (const double pole : {-90.0, 90.0}) {
    const SunPosition sun = sun_position(summer, place_of(0.0, pole));
    EXPECT_TRUE(std::isfinite(sun.azimuth_rad));
    EXPECT_NEAR(sun.zenith_rad / kDegree, 90.0 - (pole > 0.0 ? 23.1 : -23.1), 0.2);
  }
}

TEST(Sun, TurnsWithTheAxesOfAScene) {
  // +y to the east: the east is ahead, the north to the left.
  const auto east = in_scene_axes({1.0, 0.0, 0.0}, 90.0 * kDegree),
             north = in_scene_axes({0.0, 1.0, 0.5}, 90.0 * kDegree);
  EXPECT_NEAR(east[1], 1.0, 1e-15);
  EXPECT_NEAR(north[0], -1.0, 1e-15);
  EXPECT_EQ(north[2], 0.5);
  const SunPosition sun = sun_position(0.0, place_of(8.0, 49.0));
  EXPECT_NEAR(in_scene_axes(sun.direction, sun.azimuth_rad)[0], 0.0, 1e-14);
  EXPECT_NEAR(in_scene_axes(sun.direction, sun.azimuth_rad)[1], std::sin(sun.zenith_rad), 1e-14);
}

TEST(Sun, RefusesPlacesAndTimesThatAreNone) {
  EXPECT_THROW(sun_position(0.0, {2.0, 0.0, 0.0}), mtf::UsageError);
  EXPECT_THROW(sun_position(0.0, {0.0, std::nan(""), 0.0}), mtf::UsageError);
  EXPECT_THROW(sun_position(std::nan(""), {}), mtf::UsageError);
  EXPECT_THROW(sun_position(1e12, {}), mtf::UsageError);
  EXPECT_THROW(sun_position(0.0, {}, {.pressure_pa = -1.0}), mtf::UsageError);
  EXPECT_THROW(sun_crossings({}, 1.0, 0.0), mtf::UsageError);
}

}  // namespace
}  // namespace radiometry::heat
