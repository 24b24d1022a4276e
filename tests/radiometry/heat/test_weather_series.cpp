// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "mtf/error.h"
#include "radiometry/weather/demo_weather.h"
#include "radiometry/weather/instant.h"
#include "radiometry/weather/weather_series.h"
#include "tests/expect_error.h"
#include "tests/radiometry/heat/weather_cases.h"

namespace radiometry::heat {
namespace {

using enum WeatherQuantity;
using namespace test;

constexpr double kMissing = std::numeric_limits<double>::quiet_NaN();

std::string message(const std::function<void()>& action) { return message_of<mtf::UsageError>(action); }

TEST(WeatherSeries, InstantsAreLinear) {
  const auto series = make_series(hourly(Stamp::instant, {280.0, 290.0, 285.0}), kAlamosa);
  EXPECT_EQ(value_at(series, air_temperature, kBegin), 280.0);
  EXPECT_DOUBLE_EQ(value_at(series, air_temperature, kBegin + 1800.0), 285.0);
  EXPECT_DOUBLE_EQ(value_at(series, air_temperature, kBegin + 7200.0), 285.0);
  EXPECT_DOUBLE_EQ(mean_over(series, air_temperature, kBegin, kBegin + 7200.0), 286.25);
  EXPECT_EQ(break_times(series, kBegin, kBegin + 7200.0), std::vector<double>{kBegin + 3600.0});
  expect_says(message([&] { value_at(series, air_temperature, kBegin + 7201.0); }), {"records cover"});
  expect_says(message([&] { value_at(series, wind_speed, kBegin); }), {"no wind_speed"});
  EXPECT_TRUE(std::isnan(weather_at(series, kBegin)[wind_speed]));
}

// Means of every record to 1e-12, for random data with nights and steps that vary, stamped at either end.
TEST(WeatherSeries, MeansAreConserved) {
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> any(0.0, 1000.0);
  for (const Stamp stamp : {Stamp::begin, Stamp::end})
    for (int round = 0; round < 20; ++round) {
      Weather weather{.source = "random", .stamp = stamp, .time_s = {}, .values = {}};
      double t = kBegin;
      for (int i = 0; i < 60; ++i) {
        weather.time_s.push_back(t);
        weather[diffuse_horizontal].push_back(any(random) < 300.0 ? 0.0 : any(random));
        weather[air_temperature].push_back(250.0 + any(random) / 20.0);
        t += round % 2 == 0 ? 3600.0 : std::round(3000.0 + any(random));
      }
      const auto series = make_series(weather, kAlamosa);
      for (const WeatherQuantity quantity : {diffuse_horizontal, air_temperature})
        for (std::size_t i = 1; i + 1 < weather.time_s.size(); ++i) {
          const bool ends = stamp == Stamp::end;
          const double from = weather.time_s[ends ? i - 1 : i], to = weather.time_s[ends ? i : i + 1];
          const double mean = mean_over(series, quantity, from, to), given = weather[quantity][i];
          ASSERT_NEAR(mean, given, 1e-12 * std::max(given, 1.0)) << i;
        }
      for (const double value : series.value[static_cast<std::size_t>(diffuse_horizontal)]) {
        ASSERT_GE(value, 0.0);
        ASSERT_LE(value, 2000.0);
      }
    }
}

TEST(WeatherSeries, NumbersThatAreSeldomRightAreSaid) {
  const auto doubt = [](WeatherQuantity quantity, double value, double air_k) {
    Weather weather = hourly(Stamp::instant, {air_k, air_k});
    weather[quantity] = {value, value};
    const auto warnings = make_series(weather, kAlamosa).warnings;
    return warnings.empty() ? std::string() : warnings[0];
  };
  expect_says(doubt(longwave_down, 600.0, 230.0),
              {"longwave_down: 2 records", "first at 2016-01-01T00:00:00Z", "378 %"});
  expect_says(doubt(longwave_down, 60.0, 290.0), {"net flux"});
  EXPECT_EQ(doubt(longwave_down, 250.0, 280.0), "");
  expect_says(doubt(vapour_pressure, 1500.0, 283.15), {"122 % of saturation"});
  EXPECT_EQ(doubt(vapour_pressure, 1200.0, 283.15), "");
  expect_says(message([&] { doubt(vapour_pressure, 6500.0, 283.15); }), {"humidity of 530"});
  expect_says(message([&] { doubt(diffuse_horizontal, 1500.0, 283.15); }), {"global irradiance"});
  expect_says(message([&] { doubt(direct_normal, 1450.0, 283.15); }), {"above the air"});
}

TEST(WeatherSeries, StampsMoveTheMeans) {
  const auto by_end = make_series(hourly(Stamp::end, {280.0, 290.0, 300.0}), kAlamosa);
  const auto by_begin = make_series(hourly(Stamp::begin, {280.0, 290.0, 300.0}), kAlamosa);
  for (double t = 0.0; t <= 10800.0; t += 700.0)
    EXPECT_DOUBLE_EQ(value_at(by_end, air_temperature, kBegin + t), value_at(by_begin, air_temperature, kBegin + t));
}

TEST(WeatherSeries, ADayRepeats) {
  std::vector<double> day(24);
  for (std::size_t i = 0; i < day.size(); ++i) day[i] = 280.0 + static_cast<double>(i * (23 - i)) / 10.0;
  for (const Stamp stamp : {Stamp::instant, Stamp::begin, Stamp::end}) {
    const auto series = make_series(hourly(stamp, day), kAlamosa, {.repeat = Repeat::day});
    const double other_day = kBegin - 5.0 * kDay_s;
    for (double t = 0.0; t < kDay_s; t += 1234.5)
      EXPECT_NEAR(value_at(series, air_temperature, kBegin + t), value_at(series, air_temperature, other_day + t),
                  1e-9);
    const double midnight = kBegin + 3.0 * kDay_s;
    EXPECT_NEAR(value_at(series, air_temperature, midnight - 0.01), value_at(series, air_temperature, midnight + 0.01),
                1e-3);
    const auto breaks = break_times(series, midnight - 1.5 * kDay_s, midnight + 0.5 * kDay_s);
    EXPECT_EQ(breaks.size(), stamp == Stamp::instant ? 47u : 95u);
    EXPECT_TRUE(std::is_sorted(breaks.begin(), breaks.end()));
  }
  // 25 records from midnight to midnight are a day too; 26 are more.
  day.push_back(280.0);
  const auto series = make_series(hourly(Stamp::instant, day), kAlamosa, {.repeat = Repeat::day});
  EXPECT_NEAR(value_at(series, air_temperature, kBegin + kDay_s), 280.0, 1e-9);
  day.push_back(280.0);
  expect_says(message([&] { make_series(hourly(Stamp::instant, day), kAlamosa, {.repeat = Repeat::day}); }),
              {"those of one day"});
  // Half a day leaves a gap with a name.
  day.resize(12);
  const auto half = make_series(hourly(Stamp::end, day), kAlamosa, {.repeat = Repeat::day});
  ASSERT_EQ(half.gaps.size(), 1u);
  const double later = kBegin + 40.0 * kDay_s;
  expect_says(message([&] { require(half, {air_temperature}, later, later + kDay_s); }), {"is missing from"});
  EXPECT_NO_THROW(require(half, {air_temperature}, later + 600.0, later + 10.0 * 3600.0));
}

TEST(WeatherSeries, ShortGapsAreBridgedLongOnesHaveNames) {
  Weather weather = hourly(Stamp::instant, {280.0, kMissing, 284.0, kMissing, kMissing, kMissing, 280.0});
  const auto series = make_series(weather, kAlamosa);
  EXPECT_DOUBLE_EQ(value_at(series, air_temperature, kBegin + 3600.0), 282.0);
  ASSERT_EQ(series.warnings.size(), 1u);
  expect_says(series.warnings[0], {"air_temperature: 1 missing record"});
  ASSERT_EQ(series.gaps.size(), 1u);
  EXPECT_EQ(series.gaps[0].begin_s, kBegin + 2.0 * 3600.0);
  EXPECT_EQ(series.gaps[0].end_s, kBegin + 6.0 * 3600.0);
  EXPECT_EQ(value_at(series, air_temperature, kBegin + 7200.0), 284.0);
  expect_says(message([&] { value_at(series, air_temperature, kBegin + 7300.0); }), {"gap is too long"});
  const std::string all = message([&] { require(series, {air_temperature, wind_speed}, kBegin, kBegin + kDay_s); });
  expect_says(all, {"air_temperature is missing", "2016-01-01T02:00:00Z to 2016-01-01T06:00:00Z", "no wind_speed",
                    "is not covered"});
  EXPECT_NO_THROW(require(series, {air_temperature}, kBegin, kBegin + 7200.0));
  EXPECT_TRUE(make_series(weather, kAlamosa, {.longest_bridge_s = 10800.0}).gaps.empty());
}

TEST(WeatherSeries, RecordsThatAreLeftOutAreGaps) {
  for (const Stamp stamp : {Stamp::instant, Stamp::begin, Stamp::end}) {
    Weather weather = hourly(stamp, std::vector<double>(24, 280.0));
    const auto cut = [&](auto& list) { list.erase(list.begin() + 10, list.begin() + 15); };
    cut(weather.time_s);
    cut(weather[air_temperature]);
    const auto series = make_series(weather, kAlamosa);
    ASSERT_EQ(series.gaps.size(), 1u);
    const std::string text = message([&] { value_at(series, air_temperature, kBegin + 12.5 * 3600.0); });
    expect_says(text, {"gap is too long"});
    EXPECT_EQ(value_at(series, air_temperature, kBegin + 8.0 * 3600.0), 280.0);
    EXPECT_EQ(value_at(series, air_temperature, kBegin + 17.0 * 3600.0), 280.0);
  }
}

TEST(WeatherSeries, OfConstantSunlightTheGlobalOneIsNotUsed) {
  Weather weather = hourly(Stamp::instant, {288.0});
  weather[direct_normal] = {800.0};
  weather[diffuse_horizontal] = {80.0};
  EXPECT_TRUE(make_series(weather, kAlamosa).warnings.empty());
  weather[global_horizontal] = {100.0};
  const auto series = make_series(weather, kAlamosa);
  ASSERT_EQ(series.warnings.size(), 1u);
  expect_says(series.warnings[0], {"global_horizontal is not used"});
}

TEST(WeatherSeries, ConstantWeatherHasNoTime) {
  const auto series = make_series(hourly(Stamp::instant, {288.0}), kAlamosa);
  EXPECT_TRUE(series.constant());
  EXPECT_EQ(value_at(series, air_temperature, 0.0), 288.0);
  EXPECT_EQ(mean_over(series, air_temperature, 0.0, 1e9), 288.0);
  EXPECT_TRUE(break_times(series, 0.0, 1e9).empty());
  EXPECT_NO_THROW(require(series, {air_temperature}, 0.0, 1e9));
}

TEST(Weather, WrongValuesAreNamedWithTheirRecord) {
  const auto fault = [](WeatherQuantity quantity, double value) {
    Weather weather = hourly(Stamp::instant, {280.0, 281.0, 282.0});
    weather.line = {2, 3, 4};
    weather[quantity].resize(3, weather[quantity].empty() ? kMissing : 280.0);
    weather[quantity][1] = value;
    return message([&] { check_weather(weather); });
  };
  expect_says(fault(global_horizontal, 1501.0), {"test.csv:3: error: global_horizontal 1501 W/m2"});
  expect_says(fault(direct_normal, 3600.0), {"kJ"});
  expect_says(fault(diffuse_horizontal, -9999.9), {"mark missing values"});
  expect_says(fault(air_temperature, 273.15 + 95.0), {"Fahrenheit (95 degF are 35 degC)"});
  expect_says(fault(air_temperature, 273.15 + 295.0), {"kelvins that were taken"});
  expect_says(fault(air_temperature, 15.0), {"degrees Celsius"});
  expect_says(fault(wind_speed, -1.0), {"wind_speed"});
  expect_says(fault(pressure, 1013.0), {"hPa"});
  expect_says(fault(longwave_down, -60.0), {"net flux"});
  expect_says(fault(cloud_cover, 10.0), {"tenths"});
  EXPECT_EQ(fault(global_horizontal, 1499.0), "");
}

TEST(Weather, AHotMeanIsAWarning) {
  const auto series = make_series(hourly(Stamp::instant, {273.15 + 40.0, 273.15 + 50.0}), kAlamosa);
  ASSERT_EQ(series.warnings.size(), 1u);
  expect_says(series.warnings[0], {"45 degC", "Fahrenheit"});
}

TEST(Weather, RecordsOutOfOrderOrTwiceAreRefused) {
  Weather weather = hourly(Stamp::instant, {280.0, 281.0, 282.0});
  weather.line = {2, 3, 4};
  std::swap(weather.time_s[1], weather.time_s[2]);
  expect_says(message([&] { check_weather(weather); }), {"test.csv:4: error:", "2016-01-01T01:00:00Z is before"});
  weather.time_s[2] = weather.time_s[1];
  expect_says(message([&] { check_weather(weather); }), {"stands twice"});
  weather.time_s.clear();
  weather[air_temperature].clear();
  expect_says(message([&] { check_weather(weather); }), {"no records"});
}

TEST(Weather, MeansOverLongerIntervals) {
  Weather weather = hourly(Stamp::end, {280.0, 282.0, 284.0, kMissing, 288.0, kMissing}, 60.0);
  weather[wind_speed] = {1.0, 2.0, 3.0, 4.0, 5.0, 6.0};
  const Weather means = averaged(weather, 180.0);
  EXPECT_EQ(means.stamp, Stamp::end);
  EXPECT_EQ(means.time_s, (std::vector<double>{kBegin + 180.0, kBegin + 360.0}));
  EXPECT_EQ(means[air_temperature], (std::vector<double>{282.0, 288.0}));
  EXPECT_EQ(means[wind_speed], (std::vector<double>{2.0, 5.0}));
  Weather gap = weather;  // an hour without records after the first one
  gap.time_s.front() -= 3600.0;
  EXPECT_EQ(averaged(gap, 180.0)[wind_speed], (std::vector<double>{1.0, 2.5, 5.0}));
  weather.stamp = Stamp::begin;  // the same minutes, a minute later
  EXPECT_EQ(averaged(weather, 180.0)[wind_speed], (std::vector<double>{1.5, 4.0, 6.0}));
  weather[air_temperature] = std::vector<double>(6, kMissing);
  EXPECT_TRUE(std::isnan(averaged(weather, 180.0)[air_temperature][0]));
  EXPECT_THROW(averaged(weather, 0.0), mtf::UsageError);
}

TEST(DemoWeather, IsAClearDay) {
  const Weather weather = demo_weather(kAlamosa, kBegin, kBegin + 2.0 * kDay_s, 600.0);
  EXPECT_EQ(weather.time_s.size(), 289u);
  EXPECT_EQ(weather.time_s.back(), kBegin + 2.0 * kDay_s);
  const auto series = make_series(weather, kAlamosa);
  EXPECT_TRUE(series.warnings.empty());
  EXPECT_TRUE(series.gaps.empty());
  const double noon = kBegin + 19.0 * 3600.0;  // 12 h local
  EXPECT_GT(value_at(series, direct_normal, noon), 800.0);
  EXPECT_EQ(value_at(series, direct_normal, kBegin + 7.0 * 3600.0), 0.0);
  EXPECT_GT(value_at(series, air_temperature, noon + 3.0 * 3600.0),
            value_at(series, air_temperature, noon - 9.0 * 3600.0));
  EXPECT_THROW(demo_weather(kAlamosa, kBegin, kBegin + 1000.0, 300.0), mtf::UsageError);
  EXPECT_THROW(demo_weather(kAlamosa, kBegin, kBegin, 300.0), mtf::UsageError);
}

TEST(Schedule, IsLinearAndHeldAtItsEnds) {
  const Schedule schedule = make_schedule("engine.csv", {0.0, 100.0, 200.0}, {300.0, 400.0, 350.0});
  EXPECT_EQ(value_at(schedule, -5.0), 300.0);
  EXPECT_DOUBLE_EQ(value_at(schedule, 50.0), 350.0);
  EXPECT_EQ(value_at(schedule, 1e9), 350.0);
  EXPECT_EQ(break_times(schedule, 0.0, 200.0), std::vector<double>{100.0});
  EXPECT_TRUE(break_times(schedule, 300.0, 200.0).empty());
  EXPECT_EQ(value_at(constant_schedule(7.0), 1e9), 7.0);
  EXPECT_THROW(make_schedule("x", {0.0, 0.0}, {1.0, 2.0}), mtf::UsageError);
  EXPECT_THROW(make_schedule("x", {0.0}, {1.0, 2.0}), mtf::UsageError);
  EXPECT_THROW(make_schedule("x", {}, {}), mtf::UsageError);
  EXPECT_THROW(make_schedule("x", {0.0}, {kMissing}), mtf::UsageError);
}

}  // namespace
}  // namespace radiometry::heat
