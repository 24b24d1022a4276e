// SPDX-License-Identifier: Apache-2.0
#pragma once

// Air over height from CSV files: radiosondes, weather models, profiles of other programs.
//   # sounding of 12 UTC
//   altitude_m,pressure_hpa,temperature_degc,relative_humidity_percent
//   0,1013.2,15.1,72
//   1200,876.0,8.4,65
// Columns, in any order, with their unit in the name: altitude_m or altitude_km; pressure_pa or pressure_hpa;
// temperature_k or temperature_degc; the water vapour as relative_humidity (a fraction), relative_humidity_percent or
// h2o_ppmv; and, as far as they are known, the other gases by volume: co2_ppmv, o3_ppmv, n2o_ppmv, co_ppmv, ch4_ppmv,
// o2_ppmv, no_ppmv, so2_ppmv, no2_ppmv, nh3_ppmv, hno3_ppmv. Other columns are not read.

#include <array>
#include <string>
#include <string_view>
#include <vector>

namespace mtf::io {

/// The gases that a profile may have, in this order.
inline constexpr std::array<std::string_view, 12> kProfileGases{"h2o", "co2", "o3",  "n2o", "co",  "ch4",
                                                                "o2",  "no",  "so2", "no2", "nh3", "hno3"};

/// All columns have one length, of at least one row; a gas or humidity that the file does not have is empty.
struct AirProfileColumns {
  std::string source;
  std::vector<double> altitude_m;                                        ///< strictly rising
  std::vector<double> pressure_pa, temperature_k;                        ///< above 0
  std::vector<double> relative_humidity;                                 ///< over water, 0 to 1; or h2o in ppmv
  std::array<std::vector<double>, kProfileGases.size()> mixing_ratio{};  ///< ppmv, 0 to 1e6
};

/// At most 10000 rows. Throws RuntimeError when the file cannot be read, UsageError "file:line: ..." for what is wrong
/// in it: heights that do not rise, pressures that do not fall, humidity above 100 %, and values that look like those
/// of another unit (a surface pressure of 1013 Pa, a temperature of 15 K).
AirProfileColumns read_air_profile_csv(const std::string& path);
/// The same from text.
AirProfileColumns parse_air_profile_csv(std::string_view text, const std::string& source);

}  // namespace mtf::io
