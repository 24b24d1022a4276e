// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

#include "apps/scene/weather/weather_file.h"
#include "radiometry/weather/demo_weather.h"
#include "radiometry/weather/instant.h"
#include "radiometry/weather/sky.h"
#include "radiometry/weather/weather_series.h"
#include "tests/apps/scene/weather_texts.h"
#include "tests/expect_error.h"
#include "tests/replaced.h"

namespace apps::scene {
namespace {

using namespace test;
using enum radiometry::heat::WeatherQuantity;
using radiometry::heat::instant_of;
using radiometry::heat::kQuantities;
using radiometry::heat::Stamp;
using radiometry::heat::Weather;

constexpr double kDegree = 3.14159265358979323846 / 180.0;

double mean_of(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

std::string refusal(const std::string& text, const WeatherRequest& request = {}) {
  return message_of([&] { parse_weather(text, "file", request); });
}

TEST(WeatherCsv, ReadsItsUnits) {
  const WeatherFile file = parse_weather(csv_text(), "a.csv");
  EXPECT_EQ(file.format, WeatherFormat::csv);
  const Weather& weather = file.weather;
  ASSERT_EQ(weather.time_s.size(), 30u);
  EXPECT_EQ(weather.time_s[25], instant_of({2016, 1, 2}, 3600.0));
  EXPECT_EQ(weather.line[0], 3u);
  EXPECT_DOUBLE_EQ(weather[air_temperature][10], 278.15);
  EXPECT_DOUBLE_EQ(weather[vapour_pressure][10], 0.6 * radiometry::heat::saturation_pressure_pa(278.15));
  EXPECT_DOUBLE_EQ(weather[pressure][10], 101320.0);
  EXPECT_DOUBLE_EQ(weather[cloud_cover][10], 0.2);
  EXPECT_FALSE(weather.has(global_horizontal));
  EXPECT_EQ(weather.stamp, Stamp::instant);
  EXPECT_EQ(parse_weather(csv_text(), "a.csv", {.stamp = Stamp::begin}).weather.stamp, Stamp::begin);
}

TEST(WeatherCsv, SecondsCountFromTheStartOfTheRun) {
  const auto weather =
      parse_weather("time (h);wind_speed (km/h)\n0;36\n1.5;\n3;nan\n", "a.csv", {.origin_s = 1000.0}).weather;
  EXPECT_EQ(weather.time_s, (std::vector<double>{1000.0, 6400.0, 11800.0}));
  EXPECT_DOUBLE_EQ(weather[wind_speed][0], 10.0);
  EXPECT_TRUE(std::isnan(weather[wind_speed][1]) && std::isnan(weather[wind_speed][2]));
}

TEST(WeatherCsv, WritesWhatItReads) {
  const Weather weather = radiometry::heat::demo_weather({0.6, -1.8, 1500.0}, instant_of({2016, 2, 28}),
                                                         instant_of({2016, 3, 1}, 43200.0), 700.0 * 6.0 / 7.0);
  const std::string text = weather_csv(weather, {"a test"});
  const Weather again = parse_weather(text, "demo").weather;
  EXPECT_EQ(again.time_s, weather.time_s);
  EXPECT_EQ(again.values, weather.values);
  EXPECT_EQ(weather_csv(again, {"a test"}), text);
}

TEST(WeatherCsv, SaysWhatIsWrong) {
  const std::string good = csv_text();
  expect_says(refusal(replaced(good, "00:00:00Z", "00:00:00")), {"file:3: error:", "time zone"});
  expect_says(refusal(replaced(good, "wind_speed (m/s)", "wind_sped (m/s)")), {"did you mean \"wind_speed\"?"});
  expect_says(refusal(replaced(good, "(degC)", "")), {"has no unit"});
  expect_says(refusal(replaced(good, "(degC)", "(hPa)")), {"does not fit"});
  expect_says(refusal(replaced(good, "(degC)", "(degF)")), {"unknown unit \"degF\""});
  expect_says(refusal(replaced(good, "air_temperature", "wind_speed")), {"stands twice"});
  expect_says(refusal(replaced(good, "pressure (hPa)", "dew_point (hPa)")), {"does not fit"});
  expect_says(refusal(replaced(good, "pressure (hPa)", "vapour_pressure (Pa)")), {"more than once"});
  expect_says(refusal(replaced(good, "air_temperature (degC)", "longwave_up (W/m2)")),
              {"needs the column air_temperature"});
  expect_says(refusal(replaced(good, "time,", "date,")), {"to be time"});
  expect_says(refusal(replaced(good, "2016-01-01T05", "2016-01-01T04")),
              {"file:8: error:", "2016-01-01T04:00:00Z stands twice"});
  expect_says(refusal(replaced(good, "2016-01-01T05", "2016-01-01T03")), {"sort the records"});
  expect_says(refusal(replaced(good, ",1013.2,", ",x,")), {"\"x\"", "column pressure"});
  expect_says(refusal(replaced(good, ",1013.2,", ",1013,2,")), {"file:3: error: 10 values", "header has 9"});
  expect_says(refusal(replaced(good, "14.5,79", "95.5,79")), {"Fahrenheit"});
  expect_says(refusal(replaced(good, ",290,87,", ",1501,87,")), {"file:32: error: direct_normal 1501 W/m2"});
  expect_says(refusal(""), {"empty"});
  expect_says(refusal("time,wind_speed (m/s)\n"), {"no records"});
  expect_says(refusal("time (kg),wind_speed (m/s)\n0,1\n"), {"no unit of time"});
}

TEST(WeatherCsv, ReadsSchedules) {
  const auto engine = parse_schedule("time (h),temperature (degC)\n0,20\n6,80\n", "engine.csv", "K", 3600.0);
  EXPECT_DOUBLE_EQ(value_at(engine, 3600.0 * 4.0), 323.15);
  const auto fail = [](const char* text) { return message_of([&] { parse_schedule(text, "s", "W/m2", 0.0); }); };
  expect_says(fail("time (h),flux (K)\n0,20\n"), {"does not fit"});
  expect_says(fail("time (h),flux (W/m2)\n0,20\n0,30\n"), {"s:3: error:", "not after"});
  expect_says(fail("time (h),flux (W/m2)\n0,\n"), {"no missing values"});
  expect_says(fail("time (h),a (W/m2),b (W/m2)\n0,1,2\n"), {"beside time, not 2"});
}

TEST(WeatherEpw, ReadsATypicalYear) {
  const WeatherFile file = parse_weather(epw_text(), "a.epw", {.year = 2015});
  EXPECT_EQ(file.format, WeatherFormat::epw);
  ASSERT_TRUE(file.place);
  EXPECT_NEAR(file.place->longitude_rad, -105.0 * kDegree, 1e-12);
  const Weather& weather = file.weather;
  EXPECT_EQ(weather.stamp, Stamp::end);
  ASSERT_EQ(weather.time_s.size(), 24u) << "2015 has no 29 February";
  ASSERT_EQ(file.warnings.size(), 1u);
  EXPECT_EQ(parse_weather(epw_text(), "a.epw", {.year = 2016}).weather.time_s.size(), 48u);
  // Hour 13 of local standard time ends at 13:00 UTC-7.
  EXPECT_EQ(weather.time_s[12], instant_of({2015, 2, 28}, 20.0 * 3600.0));
  EXPECT_DOUBLE_EQ(weather[air_temperature][12], 279.15);
  EXPECT_DOUBLE_EQ(weather[vapour_pressure][12], 0.52 * radiometry::heat::saturation_pressure_pa(279.15));
  EXPECT_DOUBLE_EQ(weather[longwave_down][12], 212.0);
  EXPECT_DOUBLE_EQ(weather[global_horizontal][12], 120.0);
  EXPECT_DOUBLE_EQ(weather[direct_normal][12], 144.0);
  EXPECT_DOUBLE_EQ(weather[diffuse_horizontal][12], 36.0);
  EXPECT_DOUBLE_EQ(weather[wind_speed][12], 2.5);
  EXPECT_DOUBLE_EQ(weather[cloud_cover][12], 0.1);
  EXPECT_DOUBLE_EQ(weather[pressure][12], 84000.0);
  // Real years stay what they are.
  EXPECT_EQ(parse_weather(epw_text(24, {2004, 2004}), "a.epw").weather.time_s[0],
            instant_of({2004, 2, 28}, 8.0 * 3600.0));
  expect_says(message_of([&] { parse_weather(epw_text(48, {2003, 2003}), "a.epw"); }), {"no such day"});
  // Another stamp than the format's is taken, and said; what holds at the stamps does so in any case.
  for (const auto q : {air_temperature, vapour_pressure, pressure, wind_speed, cloud_cover})
    EXPECT_FALSE(weather.is_mean(static_cast<std::size_t>(q)));
  for (const auto q : {longwave_down, global_horizontal, direct_normal, diffuse_horizontal})
    EXPECT_TRUE(weather.is_mean(static_cast<std::size_t>(q)));
  const WeatherFile middle = parse_weather(epw_text(), "a.epw", {.stamp = Stamp::middle, .year = 2016});
  EXPECT_EQ(middle.weather.stamp, Stamp::middle);
  ASSERT_EQ(middle.warnings.size(), 1u);
  expect_says(middle.warnings[0], {"EPW", "end of the interval", "stamp = \"middle\""});
  expect_says(refusal(replaced(epw_text(), ",13,60,", ",25,60,")), {"file:21: error:", "date or hour"});
  EXPECT_TRUE(std::isnan(
      parse_weather(replaced(epw_text(), ",120,144,36,", ",9999,9999,9999,"), "a").weather[direct_normal][12]));
}

TEST(WeatherTmy3, ReadsTheEndOfTheDay) {
  const WeatherFile file = parse_weather(tmy3_text(), "a.csv", {.year = 2026});
  EXPECT_EQ(file.format, WeatherFormat::tmy3);
  ASSERT_EQ(file.weather.time_s.size(), 48u);
  // 31 January 24:00 UTC-5 is 1 February 05:00 UTC.
  EXPECT_EQ(file.weather.time_s[23], instant_of({2026, 2, 1}, 5.0 * 3600.0));
  EXPECT_EQ(file.weather.time_s[24] - file.weather.time_s[23], 3600.0);
  expect_says(refusal(replaced(tmy3_text(), ",24:00", ",24:30")), {"no date and time"});
  expect_says(refusal(replaced(tmy3_text(), "DNI (W/m^2)", "DNI (kJ/m^2)")), {"\"DNI (W/m^2)\" is missing"});
  EXPECT_TRUE(
      std::isnan(parse_weather(replaced(tmy3_text(), ",60,990,", ",-9900,990,"), "a").weather[vapour_pressure][0]));
}

TEST(WeatherSurfrad, FlagsAndMarksAreMissingValues) {
  const WeatherFile file = parse_weather(surfrad_text(), "a.dat");
  EXPECT_EQ(file.format, WeatherFormat::surfrad);
  EXPECT_TRUE(file.warnings.empty());
  EXPECT_NEAR(file.place->longitude_rad, -105.92 * kDegree, 1e-12);
  EXPECT_EQ(file.weather[direct_normal][7], 807.0);
  const auto flagged = parse_weather(replaced(surfrad_text(), " 807.0 0", " 807.0 2"), "a.dat");
  EXPECT_TRUE(std::isnan(flagged.weather[direct_normal][7]));
  ASSERT_EQ(flagged.warnings.size(), 1u);
  expect_says(flagged.warnings[0], {"1 values", "quality flag"});
  const auto missing = parse_weather(replaced(surfrad_text(), "   807.0 0", " -9999.9 0"), "a.dat");
  EXPECT_TRUE(std::isnan(missing.weather[direct_normal][7]));
}

TEST(WeatherTmy2, ReadsCellsByPosition) {
  const WeatherFile file = parse_weather(tmy2_text(), "a.tm2", {.year = 2026});
  EXPECT_EQ(file.format, WeatherFormat::tmy2);
  const Weather& weather = file.weather;
  ASSERT_EQ(weather.time_s.size(), 48u);
  EXPECT_EQ(weather.stamp, Stamp::end);
  EXPECT_NEAR(file.place->latitude_rad, 25.8 * kDegree, 1e-12);
  EXPECT_NEAR(file.place->longitude_rad, -(80.0 + 16.0 / 60.0) * kDegree, 1e-12);
  EXPECT_EQ(file.place->altitude_m, 2.0);
  // 31 January 24:00 UTC-5 is 1 February 05:00 UTC.
  EXPECT_EQ(weather.time_s[23], instant_of({2026, 2, 1}, 5.0 * 3600.0));
  EXPECT_EQ(weather[global_horizontal][23], 115.0);
  EXPECT_EQ(weather[direct_normal][23], 138.0);
  EXPECT_EQ(weather[diffuse_horizontal][23], 46.0);
  EXPECT_DOUBLE_EQ(weather[cloud_cover][23], 0.1);
  EXPECT_NEAR(weather[air_temperature][23], 273.15 + 4.9, 1e-9);
  EXPECT_NEAR(weather[vapour_pressure][23], 0.6 * radiometry::heat::saturation_pressure_pa(273.15 + 4.9), 1e-9);
  EXPECT_EQ(weather[pressure][23], 101700.0);
  EXPECT_NEAR(weather[wind_speed][23], 3.1, 1e-12);
  EXPECT_FALSE(weather.is_mean(static_cast<std::size_t>(air_temperature)));
  const Weather gap = parse_weather(replaced(tmy2_text(), "1017", "9999"), "a").weather;
  EXPECT_TRUE(std::isnan(gap[pressure][0]) && gap[pressure][1] == 101700.0);
  EXPECT_FALSE(std::isnan(parse_weather(replaced(tmy2_text(), " 60", " 99"), "a").weather[vapour_pressure][0]));
  EXPECT_EQ(parse_weather("\xEF\xBB\xBF" + tmy2_text(), "a").weather.values,
            parse_weather(tmy2_text(), "a").weather.values);
  expect_says(refusal(replaced(tmy2_text(), "\r\n", "0\r\n")), {"file:2: error:", "143 characters, 142 are needed"});
  expect_says(refusal(replaced(tmy2_text(), " 62 131 1", " 62 13125")), {"file:2: error:", "hours are from 1 to 24"});
}

TEST(WeatherSam, TheMinuteSaysWhatAStampIs) {
  const WeatherFile file = parse_weather(sam_text(), "a.csv");
  EXPECT_EQ(file.format, WeatherFormat::sam);
  const Weather& weather = file.weather;
  EXPECT_EQ(weather.stamp, Stamp::middle);
  EXPECT_EQ(weather.time_s[0], instant_of({2017, 1, 1}, 7.5 * 3600.0));
  EXPECT_NEAR(file.place->longitude_rad, -108.54 * kDegree, 1e-12);
  EXPECT_EQ(file.place->altitude_m, 2168.0);
  EXPECT_EQ(weather[global_horizontal][7], 35.0);
  EXPECT_EQ(weather[direct_normal][7], 42.0);
  EXPECT_EQ(weather[diffuse_horizontal][7], 14.0);
  EXPECT_NEAR(weather[air_temperature][7], 273.15 + 0.1, 1e-9);
  EXPECT_EQ(weather[pressure][7], 77900.0);
  EXPECT_NEAR(weather[vapour_pressure][7], 0.6 * radiometry::heat::saturation_pressure_pa(273.25), 1e-9);
  EXPECT_FALSE(weather.is_mean(static_cast<std::size_t>(wind_speed)));
  // Without minutes the hour begins at its stamp, for all columns; the dew point serves where humidity is not there.
  const Weather hours = parse_weather(replaced(sam_text(48, false), "Relative Humidity", "Cloud Type"), "a").weather;
  EXPECT_EQ(hours.stamp, Stamp::begin);
  EXPECT_EQ(hours.time_s[0], instant_of({2017, 1, 1}, 7.0 * 3600.0));
  EXPECT_TRUE(hours.is_mean(static_cast<std::size_t>(wind_speed)));
  EXPECT_NEAR(hours[vapour_pressure][7], radiometry::heat::saturation_pressure_pa(273.15 - 10.8), 1e-9);
  EXPECT_TRUE(std::isnan(parse_weather(replaced(sam_text(), ",35,42,", ",,-999,"), "a").weather[direct_normal][7]));
  expect_says(refusal(replaced(sam_text(), ",c,mbar,", ",f,mbar,")), {"file:2: error:", "unit \"f\"", "c is needed"});
  expect_says(refusal(replaced(sam_text(), "Time Zone", "Zone")), {"\"time zone\" has no value"});
  expect_says(refusal(replaced(sam_text(), ",Hour,", ",Hr,")), {"\"hour\" is missing"});
  expect_says(refusal(replaced(sam_text(), "2017,1,1,7,30", "2017,1,1,24,30")), {"file:11: error:", "from 0 to 23"});
}

TEST(WeatherPvgis, SunlightLiesLaterThanTheStamps) {
  const WeatherFile file = parse_weather(pvgis_text(), "a.csv", {.year = 2026});
  EXPECT_EQ(file.format, WeatherFormat::pvgis);
  EXPECT_TRUE(file.warnings.empty());
  const Weather& weather = file.weather;
  ASSERT_EQ(weather.time_s.size(), 48u) << "explanations follow the records";
  EXPECT_EQ(weather.time_s[24], instant_of({2026, 2, 1}));
  EXPECT_NEAR(weather.later_s, 0.1761 * 3600.0, 1e-9);
  EXPECT_EQ(weather[direct_normal][10], 60.0);
  EXPECT_EQ(weather[longwave_down][10], 260.0);
  EXPECT_NEAR(weather[air_temperature][10], 274.15, 1e-9);
  EXPECT_EQ(weather[pressure][10], 99870.0);
  // The hour of sunlight around the image of 10:10 keeps its mean; the temperature holds at 10:00.
  const auto series = make_series(weather, *file.place);
  const double middle = weather.time_s[10] + weather.later_s;
  EXPECT_NEAR(mean_over(series, global_horizontal, middle - 1800.0, middle + 1800.0), 50.0, 1e-9);
  EXPECT_NEAR(value_at(series, air_temperature, weather.time_s[10]), 274.15, 1e-9);
  const std::string blank = replaced(pvgis_text(), "20180131:0500", "\r\n20180131:0500");
  EXPECT_EQ(parse_weather(blank, "a").weather.time_s.size(), 48u) << "a blank line ends nothing";
  expect_says(refusal(replaced(pvgis_text(), "20180131:0500", "the rest\n20180131:0500")),
              {"file:14: error:", "records follow"});
  const WeatherFile old = parse_weather(replaced(pvgis_text(), "Irradiance Time", "Some Time"), "a.csv");
  EXPECT_EQ(old.weather.later_s, 0.0);
  ASSERT_EQ(old.warnings.size(), 1u);
  expect_says(old.warnings[0], {"irradiance time offset", "half an hour"});
  expect_says(refusal(replaced(pvgis_text(), "Gb(n)", "Gb(i)")), {"inclined plane", "typical meteorological year"});
  expect_says(refusal(replaced(pvgis_text(), "20180131:0500", "20180131 0500")), {"file:14: error:", "20160131:2300"});
}

TEST(WeatherFiles, AnUnknownFormatIsToldWhatIsRead) {
  expect_says(refusal("Station;Date\n1;2\n"), {"file:1: error: none of the formats", "CSV (", "EPW (", "TMY2 (",
                                               "TMY3 (", "SURFRAD (", "SAM CSV (NSRDB)", "PVGIS TMY ("});
}

// Greensboro: all 8760 hours; sums by another program, and the hour 15 July 12 to 13 h by hand.
TEST(WeatherShared, Tmy3FileIsReadWhole) {
  const std::string path = shared_weather("723170TYA.CSV");
  if (path.empty()) GTEST_SKIP() << "no shared data";
  const WeatherFile file = read_weather(path, {.year = 2001});
  EXPECT_EQ(file.format, WeatherFormat::tmy3);
  const Weather& weather = file.weather;
  ASSERT_EQ(weather.time_s.size(), 8760u);
  EXPECT_EQ(weather.time_s.front(), instant_of({2001, 1, 1}, 6.0 * 3600.0));
  EXPECT_EQ(weather.time_s.back(), instant_of({2002, 1, 1}, 5.0 * 3600.0));
  for (std::size_t i = 1; i < weather.time_s.size(); ++i) ASSERT_EQ(weather.time_s[i] - weather.time_s[i - 1], 3600.0);
  EXPECT_NEAR(mean_of(weather[global_horizontal]), 178.79029680365298, 1e-9);
  EXPECT_NEAR(mean_of(weather[direct_normal]), 168.55582191780823, 1e-9);
  EXPECT_NEAR(mean_of(weather[diffuse_horizontal]), 77.87933789954337, 1e-9);
  EXPECT_NEAR(mean_of(weather[air_temperature]) - 273.15, 14.421849315068439, 1e-9);
  EXPECT_NEAR(mean_of(weather[pressure]), 98691.72374429223, 1e-6);
  EXPECT_NEAR(mean_of(weather[wind_speed]), 3.0544406392692225, 1e-9);
  EXPECT_NEAR(mean_of(weather[cloud_cover]), 0.48094748858447485, 1e-9);
  const auto found = std::find(weather.line.begin(), weather.line.end(), 4695u);
  ASSERT_NE(found, weather.line.end());
  const auto i = static_cast<std::size_t>(found - weather.line.begin());
  EXPECT_EQ(weather.time_s[i], instant_of({2001, 7, 15}, 18.0 * 3600.0));
  EXPECT_EQ(weather[global_horizontal][i], 919.0);
  EXPECT_EQ(weather[direct_normal][i], 727.0);
  EXPECT_EQ(weather[diffuse_horizontal][i], 215.0);
  EXPECT_DOUBLE_EQ(weather[air_temperature][i], 273.15 + 29.4);
  // The stamps and the zone are right where global = direct x cos z + diffuse of the hour's middle.
  double worst = 0.0;
  for (std::size_t k = 0; k < weather.time_s.size(); ++k) {
    const double up = radiometry::heat::sun_position(weather.time_s[k] - 1800.0, *file.place).direction[2];
    if (up > 0.3)
      worst = std::max(worst, std::abs(weather[direct_normal][k] * up + weather[diffuse_horizontal][k] -
                                       weather[global_horizontal][k]));
  }
  EXPECT_LT(worst, 30.0);
  const auto series = make_series(weather, *file.place);
  EXPECT_TRUE(series.gaps.empty());
  for (std::size_t k = 1; k < 200; ++k)
    ASSERT_NEAR(mean_over(series, global_horizontal, weather.time_s[k - 1], weather.time_s[k]),
                weather[global_horizontal][k], 1e-9);
}

// Alamosa: all 1440 minutes; means by another program, and 19:00 UTC by hand.
TEST(WeatherShared, SurfradFileIsReadWhole) {
  const std::string path = shared_weather("surfrad-slv16001.dat");
  if (path.empty()) GTEST_SKIP() << "no shared data";
  const WeatherFile file = read_weather(path);
  EXPECT_EQ(file.format, WeatherFormat::surfrad);
  EXPECT_TRUE(file.warnings.empty());
  const Weather& weather = file.weather;
  ASSERT_EQ(weather.time_s.size(), 1440u);
  EXPECT_EQ(weather.time_s.front(), instant_of({2016, 1, 1}));
  EXPECT_NEAR(mean_of(weather[global_horizontal]), 140.36854166666674, 1e-9);
  EXPECT_NEAR(mean_of(weather[solar_up]), 26.528472222222224, 1e-9);
  EXPECT_NEAR(mean_of(weather[direct_normal]), 355.88513888888843, 1e-9);
  EXPECT_NEAR(mean_of(weather[diffuse_horizontal]), 18.08736111111112, 1e-9);
  EXPECT_NEAR(mean_of(weather[longwave_down]), 179.12090277777767, 1e-9);
  EXPECT_NEAR(mean_of(weather[longwave_up]), 266.28236111111056, 1e-9);
  EXPECT_NEAR(mean_of(weather[air_temperature]) - 273.15, -13.72868055555556, 1e-9);
  EXPECT_NEAR(mean_of(weather[wind_speed]), 1.2881944444444429, 1e-9);
  EXPECT_NEAR(mean_of(weather[pressure]), 77624.06250000012, 1e-6);
  const std::size_t i = 19 * 60;
  EXPECT_EQ(weather.line[i], 1143u);
  EXPECT_EQ(weather.time_s[i], instant_of({2016, 1, 1}, 19.0 * 3600.0));
  EXPECT_EQ(weather[global_horizontal][i], 579.1);
  EXPECT_EQ(weather[direct_normal][i], 1075.1);
  EXPECT_EQ(weather[diffuse_horizontal][i], 59.1);
  EXPECT_EQ(weather[longwave_up][i], 329.6);
  EXPECT_DOUBLE_EQ(weather[air_temperature][i], 273.15 - 6.5);
  // The file's own (refracted) zenith angles, mid-morning, noon and mid-afternoon, are those of the middle of the
  // minute that ends at the stamp: 30 s are 0.06 deg in the morning and in the afternoon.
  for (const auto& [minute, zenith_deg] :
       {std::pair{16 * 60 + 20, 72.30}, std::pair{19 * 60, 60.69}, std::pair{22 * 60, 72.89}})
    EXPECT_NEAR(radiometry::heat::sun_position(instant_of({2016, 1, 1}, 60.0 * minute - 30.0), *file.place,
                                               {.pressure_pa = 77800.0, .temperature_k = 266.0})
                        .zenith_rad /
                    kDegree,
                zenith_deg, 0.025);
  const auto series = make_series(weather, *file.place, {.repeat = radiometry::heat::Repeat::day});
  EXPECT_TRUE(series.gaps.empty());
  // 5-min means: 289 of them, as the first minute belongs to the day before.
  const auto means = make_series(averaged(weather, 300.0), *file.place, {.repeat = radiometry::heat::Repeat::day});
  EXPECT_TRUE(means.gaps.empty());
  EXPECT_EQ(means.node_s.size(), 3u * 288u + 2u);  // begin, middle and end of each, sunrise and sunset
  const double noon = instant_of({2016, 1, 4}, 19.0 * 3600.0);
  EXPECT_NEAR(mean_over(means, direct_normal, noon, noon + 300.0), mean_over(series, direct_normal, noon, noon + 300.0),
              1e-9);
  const double later = instant_of({2016, 1, 5});
  EXPECT_NO_THROW(require(series, {direct_normal, longwave_down, wind_speed}, later, later + 172800.0));
}

// Damage of every kind ends in an error of ours or in numbers, never in anything else.
void expect_damage_read_or_refused(int rounds) {
  std::uint64_t state = 12345;
  const auto random = [&](std::size_t below) {
    state = state * 6364136223846793005u + 1442695040888963407u;
    return static_cast<std::size_t>(state >> 33) % below;
  };
  int refused = 0, read = 0;
  for (const std::string& good :
       {csv_text(12), epw_text(12), tmy3_text(12), surfrad_text(12), tmy2_text(12), sam_text(12), pvgis_text(12)})
    for (int round = 0; round < rounds; ++round) {
      std::string text = good;
      for (std::size_t k = 0; k <= random(3); ++k) text[random(text.size())] = static_cast<char>(random(256));
      if (round % 5 == 0) text.resize(random(text.size() + 1));
      try {
        const WeatherFile file = parse_weather(text, "damaged");
        check_weather(file.weather);
        const auto series = make_series(file.weather, file.place.value_or(radiometry::heat::Place{}));
        EXPECT_TRUE(std::is_sorted(series.node_s.begin(), series.node_s.end()));
        ++read;
      } catch (const mtf::UsageError& error) {
        expect_says(error.what(), {"damaged"});
        ++refused;
      }
    }
  EXPECT_GT(refused, 2 * rounds / 3);
  EXPECT_GT(read, rounds / 5);
}
TEST(WeatherDamaged, FlippedBytesAndCutFiles) { expect_damage_read_or_refused(300); }
TEST(WeatherDamagedLong, FlippedBytesAndCutFiles) { expect_damage_read_or_refused(1500); }

/// The text without its cell `k` in every line of data.
std::string without_column(const std::string& text, std::size_t k, char separator, int first_line) {
  std::string result;
  int line = 0;
  for (std::size_t at = 0; at < text.size(); ++line) {
    const std::size_t end = std::min(text.find('\n', at), text.size());
    std::string row = text.substr(at, end - at);
    at = end + 1;
    if (line >= first_line && !row.starts_with('#')) {
      std::size_t begin = 0;
      for (std::size_t i = 0; i < k; ++i) begin = row.find(separator, begin) + 1;
      const std::size_t stop = row.find(separator, begin);
      row = stop == std::string::npos ? row.substr(0, begin - 1) : row.erase(begin, stop + 1 - begin);
    }
    result += row + "\n";
  }
  return result;
}

TEST(WeatherDamaged, EveryColumnMissingInTurn) {
  const Weather full = parse_weather(csv_text(), "file").weather;
  for (std::size_t k = 0; k < 9; ++k) {
    const std::string text = without_column(csv_text(), k, ',', 0);
    if (k <= 1) {  // time, and the temperature that the humidity needs
      EXPECT_NE(refusal(text), "");
      continue;
    }
    const Weather weather = parse_weather(text, "file").weather;
    int absent = 0;
    for (std::size_t q = 0; q < kQuantities; ++q)
      if (weather.values[q].empty() && !full.values[q].empty())
        ++absent;
      else
        EXPECT_EQ(weather.values[q], full.values[q]);
    EXPECT_EQ(absent, 1) << k;
  }
  for (std::size_t k = 0; k < 10; ++k) EXPECT_NE(refusal(without_column(tmy3_text(), k, ',', 1)), "") << k;
  for (std::size_t k = 0; k < 35; ++k)
    EXPECT_TRUE(says(refusal(without_column(epw_text(), k, ',', 8)), "34 cells")) << k;
  // Blanks separate; every run of them is one separator.
  std::string surfrad = surfrad_text(3);
  for (std::size_t at = 0; (at = surfrad.find("  ", at)) != std::string::npos;) surfrad.erase(at, 1);
  for (std::size_t k = 1; k <= 48; ++k)
    EXPECT_TRUE(says(refusal(without_column(surfrad, k, ' ', 2)), "47 numbers, 48 are needed")) << k;
}

}  // namespace
}  // namespace apps::scene
