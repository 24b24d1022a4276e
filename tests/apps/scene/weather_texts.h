// SPDX-License-Identifier: Apache-2.0
#pragma once

// Small weather files of each format for tests, and the shared measured ones.

#include <array>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <string>

#include "mtf/error.h"
#include "tests/expect_error.h"

namespace apps::scene::test {

/// Empty without the shared data.
inline std::string shared_weather(const std::string& name) {
  const char* chosen = std::getenv("MTFKIT_SHARED");
  const std::filesystem::path shared =
      chosen != nullptr ? std::filesystem::path(chosen) : std::filesystem::path(MTFKIT_SOURCE_DIR) / "../shared";
  const auto file = shared / "data/weather" / name;
  return std::filesystem::exists(file) ? file.string() : std::string();
}

template <class... Values>
std::string formatted(const char* format, Values... values) {
  std::array<char, 1024> text{};
  const int size = std::snprintf(text.data(), text.size(), format, values...);
  return {text.data(), static_cast<std::size_t>(size)};
}

inline std::string csv_text(int hours = 30) {
  std::string text =
      "# made for a test\n"
      "time,air_temperature (degC),relative_humidity (%),wind_speed (m/s),pressure (hPa),direct_normal (W/m2),"
      "diffuse_horizontal (W/m2),longwave_down (W/m2),cloud_cover (%)\n";
  for (int i = 0; i < hours; ++i)
    text += formatted("2016-01-%02dT%02d:00:00Z,%.1f,%d,%.1f,1013.2,%d,%d,%d,%d\n", 1 + i / 24, i % 24, 0.5 * i,
                      50 + i % 40, 0.1 * i, 10 * i, 3 * i, 250 + i, 2 * i % 100);
  return text;
}

inline std::string epw_text(int hours = 48, const std::array<int, 2>& years = {1999, 2003}) {
  std::string text =
      "LOCATION,Somewhere,XX,USA,TMY2,123456,40.00,-105.00,-7.0,1600.0\nDESIGN CONDITIONS,0\n"
      "TYPICAL/EXTREME PERIODS,0\nGROUND TEMPERATURES,0\nHOLIDAYS/DAYLIGHT SAVINGS,No,0,0,0\nCOMMENTS 1,\n"
      "COMMENTS 2,\nDATA PERIODS,1,1,Data,Sunday, 1/ 1,12/31\n";
  for (int i = 0; i < hours; ++i)
    text += formatted(
        "%d,2,%d,%d,60,?9?9,%.1f,%.1f,%d,84000,0,1415,%d,%d,%d,%d,0,0,0,0,270,%.1f,5,%d,16.1,77777,9,"
        "999999999,10,0.08,0,88,0.2,0,0\n",
        years[static_cast<std::size_t>(i / 24 % 2)], 28 + i / 24, 1 + i % 24, 0.5 * i, -5.0, 40 + i % 24, 200 + i,
        10 * i, 12 * i, 3 * i, 2.5, i % 11);
  return text;
}

inline std::string tmy3_text(int hours = 48) {
  std::string text =
      "723170,\"GREENSBORO\",NC,-5.0,36.100,-79.950,273\n"
      "Date (MM/DD/YYYY),Time (HH:MM),GHI (W/m^2),DNI (W/m^2),DHI (W/m^2),OpqCld (tenths),Dry-bulb (C),RHum (%),"
      "Pressure (mbar),Wspd (m/s)\n";
  for (int i = 0; i < hours; ++i)
    text += formatted("%02d/%02d/%d,%02d:00,%d,%d,%d,%d,%.1f,%d,990,%.1f\n", i < 24 ? 1 : 2, i < 24 ? 31 : 1,
                      i < 24 ? 1988 : 1981, 1 + i % 24, 5 * i, 6 * i, 2 * i, i % 11, 0.3 * i, 60, 3.1);
  return text;
}

inline std::string surfrad_text(int minutes = 60) {
  std::string text = " Alamosa\n   37.70  105.92 2317 m version 1\n";
  for (int i = 0; i < minutes; ++i) {
    text += formatted(" 2016   1  1  1 %2d %2d %6.3f  91.65", i / 60, i % 60, i / 60.0);
    const std::array values{400.0 + i, 50.0, 800.0 + i, 90.0,  186.3,           -5.7, -6.2, 276.0, -6.3, -6.4, -9999.9,
                            -9999.9,   -1.0, -89.7,     -90.7, -7.6 + i / 10.0, 52.7, 3.1,  304.7, 773.5};
    for (const double value : values) text += formatted(" %7.1f %d", value, value < -9999.0 ? 1 : 0);
    text += "\n";
  }
  return text;
}

inline std::string tmy2_text(int hours = 48) {
  std::string text = " 12839 MIAMI                  FL  -5 N 25 48 W  80 16     2\n";
  for (int i = 0; i < hours; ++i) {
    std::string row(142, '0');
    const auto put = [&](std::size_t position, const std::string& cell) {
      row.replace(position - 1, cell.size(), cell);
    };
    put(1, formatted(" %02d%2d%2d%2d", i < 24 ? 62 : 71, i < 24 ? 1 : 2, i < 24 ? 31 : 1, 1 + i % 24));
    put(18, formatted("%4d", 5 * i));       // global
    put(24, formatted("%4d", 6 * i));       // direct
    put(30, formatted("%4d", 2 * i));       // diffuse
    put(64, formatted("%2d", i % 11));      // opaque clouds, tenths
    put(68, formatted("%4d", 3 * i - 20));  // tenths of a degree Celsius
    put(80, " 60");                         // relative humidity
    put(85, formatted("%4d", 1017));        // mbar
    put(96, formatted("%3d", 31));          // tenths of m/s
    text += row + "\r\n";
  }
  return text;
}

inline std::string sam_text(int records = 48, bool minutes = true) {
  std::string text =
      "Source,Location ID,Latitude,Longitude,Time Zone,Elevation,Local Time Zone,Temperature Units,Pressure Units,DNI "
      "Units,Version\nNSRDB,401182,40.53,-108.54,-7,2168,-7,c,mbar,w/m2,v3.2.2\nYear,Month,Day,Hour,";
  text += minutes ? "Minute,DHI,GHI,DNI,Dew Point,Surface Albedo,Wind Speed,Relative Humidity,Temperature,Pressure,,\n"
                  : "DHI,GHI,DNI,Dew Point,Surface Albedo,Wind Speed,Relative Humidity,Temperature,Pressure\n";
  for (int i = 0; i < records; ++i) {
    text += formatted("2017,1,%d,%d", 1 + i / 24, i % 24) + (minutes ? ",30" : "");
    text += formatted(",%d,%d,%d,-10.8,0.8,%.1f,60,%.1f,779%s\n", 2 * i, 5 * i, 6 * i, 0.1 * i, 0.3 * i - 2.0,
                      minutes ? ",," : "");
  }
  return text;
}

inline std::string pvgis_text(int hours = 48) {
  std::string text =
      "Latitude (decimal degrees): 45.000\r\nLongitude (decimal degrees): 8.000\r\nElevation (m): 250.0\r\n"
      "Irradiance Time Offset (h): 0.1761\r\nmonth,year\r\n1,2018\r\n2,2007\r\n"
      "time(UTC),T2m,RH,G(h),Gb(n),Gd(h),IR(h),WS10m,WD10m,SP\r\n";
  for (int i = 0; i < hours; ++i)
    text += formatted("%s:%02d00,%.2f,60.0,%d.0,%d.0,%d.0,%.2f,0.75,257.0,99870.0\r\n",
                      i < 24 ? "20180131" : "20070201", i % 24, 0.3 * i - 2.0, 5 * i, 6 * i, 2 * i, 250.0 + i);
  return text + "\r\nT2m: 2-m air temperature (degree Celsius)\r\n\r\nPVGIS (c) European Union, 2001-2025\r\n";
}

}  // namespace apps::scene::test
