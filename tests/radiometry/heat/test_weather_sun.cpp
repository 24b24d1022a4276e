// SPDX-License-Identifier: Apache-2.0
// Sunlight of records: spread by the course of the sun, closed by it, and compared with it.

#include <gtest/gtest.h>

#include <cmath>

#include "radiometry/weather/demo_weather.h"
#include "radiometry/weather/instant.h"
#include "radiometry/weather/weather_series.h"
#include "tests/expect_error.h"
#include "tests/radiometry/heat/weather_cases.h"

namespace radiometry::heat {
namespace {

using enum WeatherQuantity;
using namespace test;

TEST(WeatherSun, NightStaysDark) {
  Weather weather = hourly(Stamp::end, {280.0, 280.0, 280.0, 280.0});
  weather[diffuse_horizontal] = {0.0, 0.0, 50.0, 0.0};
  const auto series = make_series(weather, kAlamosa);
  for (double t = 0.0; t < 7200.0; t += 300.0) EXPECT_EQ(value_at(series, diffuse_horizontal, kBegin + t), 0.0);
  EXPECT_EQ(value_at(series, diffuse_horizontal, kBegin + 7200.0, Limit::before), 0.0);
  // The sun is down here all the time and tells nothing of the hour that has light: it stays as it is.
  for (double t = 7200.0; t < 10800.0; t += 300.0)
    EXPECT_DOUBLE_EQ(value_at(series, diffuse_horizontal, kBegin + t), 50.0);
  EXPECT_EQ(value_at(series, diffuse_horizontal, kBegin + 10800.0), 0.0);
  EXPECT_EQ(break_times(series, kBegin, kBegin + 14400.0, true),
            (std::vector<double>{kBegin + 7200.0, kBegin + 10800.0}));
}

// An hour of light between two with little: its mean is kept by what the sun does in it, and its neighbours' too, so
// that nothing is above the hour's own course. (A line through the middles had 780 W/m2 for the 597 of a file.)
TEST(WeatherSun, SunlightDoesNotOvershoot) {
  const double noon = kBegin + 19.0 * 3600.0;  // of Alamosa
  Weather weather{.source = "hours", .stamp = Stamp::end, .time_s = {}, .values = {}};
  const std::vector<double> hours{100.0, 230.0, 597.0, 240.0, 90.0};
  for (std::size_t i = 0; i < hours.size(); ++i)
    weather.time_s.push_back(noon + 3600.0 * (static_cast<double>(i) - 1.5));
  weather[diffuse_horizontal] = hours;
  const auto series = make_series(weather, kAlamosa);
  for (std::size_t i = 0; i < hours.size(); ++i) {
    const double end = weather.time_s[i], begin = end - 3600.0;
    EXPECT_NEAR(mean_over(series, diffuse_horizontal, begin, end), hours[i], 1e-9);
    // The height of the sun, and with it light from the sky, changes by less than a fifth of the mean in these hours.
    for (double t = begin; t < end; t += 60.0)
      EXPECT_NEAR(value_at(series, diffuse_horizontal, t), hours[i], 0.2 * hours[i]);
  }
}

// Beam of 800 W/m2 while the sun is up: the records of the hours of sunrise and sunset have a part of it, and the line
// has it in that part.
TEST(WeatherSun, LightBeginsAndEndsWithTheDay) {
  Weather weather{.source = "hours", .stamp = Stamp::end, .time_s = {}, .values = {}};
  const auto up = [](double t) { return sun_position(t, kAlamosa).direction[2] > 0.0; };
  for (int hour = 1; hour <= 24; ++hour) {
    double part = 0.0;
    for (double t = -3595.0; t < 0.0; t += 10.0) part += up(kBegin + 3600.0 * hour + t) ? 1.0 / 360.0 : 0.0;
    weather.time_s.push_back(kBegin + 3600.0 * hour);
    weather[direct_normal].push_back(800.0 * part);
  }
  const auto series = make_series(weather, kAlamosa);
  for (int hour = 0; hour < 24; ++hour) {
    const double begin = kBegin + 3600.0 * hour;
    EXPECT_NEAR(mean_over(series, direct_normal, begin, begin + 3600.0),
                weather[direct_normal][static_cast<std::size_t>(hour)], 1e-9);
  }
  for (double t = kBegin; t < kBegin + kDay_s; t += 300.0) {
    EXPECT_LE(value_at(series, direct_normal, t), up(t) ? 1420.0 : 1e-6);
  }
  EXPECT_TRUE(series.warnings.empty()) << series.warnings.front();
  // A beam at night, as of a wrong zone, is said.
  for (double& t : weather.time_s) t += 7.0 * 3600.0;
  const auto shifted = make_series(weather, kAlamosa);
  ASSERT_EQ(shifted.warnings.size(), 1u);
  expect_says(shifted.warnings[0], {"more light"});
}

// Hours of sunlight beside temperatures that hold at the stamps.
TEST(WeatherSun, InstantsBesideMeansHoldAtTheirStamps) {
  for (const Stamp stamp : {Stamp::begin, Stamp::middle, Stamp::end}) {
    Weather weather = hourly(stamp, {280.0, 281.0, 282.0, 283.0});
    weather[diffuse_horizontal] = {40.0, 80.0, 120.0, 160.0};
    weather.at_stamp[static_cast<std::size_t>(air_temperature)] = true;
    const auto series = make_series(weather, {});
    for (std::size_t i = 0; i < 4; ++i) {
      const double t = weather.time_s[i];
      EXPECT_DOUBLE_EQ(value_at(series, air_temperature, t), weather[air_temperature][i]);
      EXPECT_NEAR(value_at(series, air_temperature, std::max(t - 900.0, weather.time_s[0])),
                  std::max(weather[air_temperature][i] - 0.25, 280.0), 1e-9);
      const double middle = t + to_middle(stamp) * 3600.0;
      EXPECT_NEAR(mean_over(series, diffuse_horizontal, middle - 1800.0, middle + 1800.0),
                  weather[diffuse_horizontal][i], 1e-9);
    }
    EXPECT_EQ(series.first_stamp_s, weather.time_s.front());
    EXPECT_EQ(series.last_stamp_s, weather.time_s.back());
    // Before the first stamp and after the last one the rest of the interval has the nearest value.
    EXPECT_EQ(value_at(series, air_temperature, series.node_s.front()), 280.0);
    EXPECT_EQ(value_at(series, air_temperature, series.node_s.back()), 283.0);
  }
}

/// A clear day at Alamosa in records of an hour or half of one, whose stamps stand for `truth`: means of steps of 60 s.
Weather clear_day(Stamp truth, double step_s) {
  Weather weather{.source = "clear", .stamp = truth, .time_s = {}, .values = {}};
  for (double t = kBegin + kDay_s; t < kBegin + 2.0 * kDay_s; t += step_s) {
    double b = 0.0, d = 0.0, g = 0.0;
    const int parts = truth == Stamp::instant ? 1 : static_cast<int>(step_s / 60.0);
    const double middle = t + to_middle(truth) * step_s;
    for (int k = 0; k < parts; ++k) {
      const double at = truth == Stamp::instant ? t : middle + 60.0 * (k + 0.5) - 0.5 * step_s;
      const double sine = sun_position(at, kAlamosa).direction[2];
      if (sine <= 0.0) continue;
      b += 950.0 * std::exp(-0.1 / sine) / parts;
      d += 70.0 * std::sqrt(sine) / parts;
      g += (950.0 * std::exp(-0.1 / sine) * sine + 70.0 * std::sqrt(sine)) / parts;
    }
    weather.time_s.push_back(t);
    weather[direct_normal].push_back(b);
    weather[diffuse_horizontal].push_back(d);
    weather[global_horizontal].push_back(g);
  }
  return weather;
}

TEST(WeatherSun, StampsThatTheSunContradictsAreSaid) {
  for (const double step_s : {3600.0, 1800.0})
    for (const Stamp truth : {Stamp::begin, Stamp::middle, Stamp::end, Stamp::instant})
      for (const Stamp taken : {Stamp::begin, Stamp::middle, Stamp::end, Stamp::instant}) {
        Weather weather = clear_day(truth, step_s);
        weather.stamp = taken;
        const auto warnings = make_series(weather, kAlamosa).warnings;
        const std::string where = std::string(stamp_name(truth)) + " taken for " + std::string(stamp_name(taken));
        if (to_middle(truth) == to_middle(taken)) {
          EXPECT_TRUE(warnings.empty()) << where << ": " << warnings.front();
          continue;
        }
        ASSERT_FALSE(warnings.empty()) << where;
        expect_says(warnings[0], {"not fit the sun"});
        const Stamp said = truth == Stamp::instant ? Stamp::middle : truth;
        EXPECT_TRUE(says(warnings[0], "stamp = \"" + std::string(stamp_name(said)) + "\""))
            << where << ": " << warnings[0];
      }
  Weather wrong = clear_day(Stamp::end, 3600.0);
  for (double& g : wrong[global_horizontal]) g *= 1.3;
  const auto warnings = make_series(wrong, kAlamosa).warnings;
  ASSERT_EQ(warnings.size(), 1u);
  expect_says(warnings[0], {"global_horizontal contradicts"});
}

// A clear day whose stamps are seven hours off, as local time that is taken for UTC: instants with two solar columns,
// of which some fall into the night.
TEST(WeatherSun, LightOfInstantsAtNightIsSaid) {
  for (const WeatherQuantity absent : {direct_normal, diffuse_horizontal, global_horizontal})
    for (const double off_s : {0.0, -7.0 * 3600.0}) {
      Weather weather = demo_weather(kAlamosa, kBegin, kBegin + kDay_s, 1200.0);
      weather[absent].clear();
      for (double& t : weather.time_s) t += off_s;
      std::string all;
      for (const std::string& text : make_series(weather, kAlamosa).warnings) all += text;
      EXPECT_EQ(says(all, "more light than the sun can give"), off_s != 0.0) << quantity_name(absent) << ": " << all;
    }
}

TEST(WeatherSun, TheThirdSolarColumnFollowsFromTheTrueSun) {
  const Weather full = demo_weather(kAlamosa, kBegin, kBegin + kDay_s, 1200.0);
  for (const WeatherQuantity absent : {direct_normal, diffuse_horizontal, global_horizontal}) {
    Weather weather = full;
    weather[absent].clear();
    const auto series = make_series(weather, kAlamosa);
    ASSERT_TRUE(series.has(absent));
    ASSERT_FALSE(series.warnings.empty());
    for (std::size_t i = 0; i < full.time_s.size(); ++i)
      EXPECT_NEAR(series.value[static_cast<std::size_t>(absent)][i], full[absent][i], 1e-8) << i;
  }
}

// Hourly means of a beam of 800 W/m2 and 100 W/m2 of diffuse light while the sun is up: the mean of B max(cos z, 0) is
// integrated here with steps of 10 s, and so is that of the line that is made of the other two.
TEST(WeatherSun, HourlyMeansAreClosedByTheMeanCosine) {
  Weather weather{.source = "means", .stamp = Stamp::end, .time_s = {}, .values = {}};
  for (int hour = 1; hour <= 24; ++hour) {
    const double end = kBegin + 3600.0 * hour;
    double cosine = 0.0;
    for (double t = end - 3595.0; t < end; t += 10.0)
      cosine += std::max(sun_position(t, kAlamosa).direction[2], 0.0) / 360.0;
    weather.time_s.push_back(end);
    weather[diffuse_horizontal].push_back(cosine > 0.0 ? 100.0 : 0.0);
    weather[global_horizontal].push_back(800.0 * cosine + weather[diffuse_horizontal].back());
  }
  const auto series = make_series(weather, kAlamosa);
  int lit = 0;
  for (int hour = 0; hour < 24; ++hour) {
    double horizontal = 0.0;
    for (double t = kBegin + 3600.0 * hour + 5.0; t < kBegin + 3600.0 * (hour + 1); t += 10.0)
      horizontal += value_at(series, direct_normal, t) * std::max(sun_position(t, kAlamosa).direction[2], 0.0) / 360.0;
    const double global = weather[global_horizontal][static_cast<std::size_t>(hour)];
    const double beam = global - weather[diffuse_horizontal][static_cast<std::size_t>(hour)];
    if (global < 20.0) continue;
    ++lit;
    EXPECT_NEAR(horizontal, beam, 0.3 + 0.002 * beam) << hour;  // lines 10 minutes long
  }
  EXPECT_GE(lit, 9);
}

}  // namespace
}  // namespace radiometry::heat
