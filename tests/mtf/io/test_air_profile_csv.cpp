// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "mtf/io/csv/air_profile_csv.h"
#include "tests/expect_error.h"
#include "tests/mtf/io/io_test_files.h"

namespace mtf::io {
namespace {

using Numbers = std::vector<double>;

TEST(AirProfileCsv, units_and_order_of_columns) {
  for (const std::string text :
       {"altitude_m,pressure_hpa,temperature_degc,relative_humidity_percent\n0,1000,15,50\n1500,850,5,25\n",
        "# "
        "sounding\nnote;relative_humidity;temperature_k;altitude_km;pressure_pa\na;0.5;288.15;0;1e5\nb;.25;278.15;1.5;"
        "85000\n"}) {
    const AirProfileColumns p = parse_air_profile_csv(text, "p.csv");
    EXPECT_EQ(p.altitude_m, (Numbers{0, 1500}));
    EXPECT_EQ(p.pressure_pa, (Numbers{1e5, 85e3}));
    EXPECT_EQ(p.temperature_k, (Numbers{288.15, 278.15}));
    EXPECT_EQ(p.relative_humidity, (Numbers{0.5, 0.25}));
    for (const Numbers& gas : p.mixing_ratio) EXPECT_TRUE(gas.empty());
  }
  const AirProfileColumns gases =
      parse_air_profile_csv("altitude_m,pressure_hpa,temperature_k,o3_ppmv,h2o_ppmv\n0,1013,288,0.03,7745\n", "p.csv");
  EXPECT_TRUE(gases.relative_humidity.empty());
  EXPECT_EQ(gases.mixing_ratio[0], (Numbers{7745}));
  EXPECT_EQ(gases.mixing_ratio[2], (Numbers{0.03}));
}

void expect_error(const std::string& text, std::initializer_list<std::string_view> parts) {
  SCOPED_TRACE(text);
  expect_says(expect_refused(parts, [&] { parse_air_profile_csv(text, "p.csv"); }), {"p.csv:"});
}

TEST(AirProfileCsv, errors_name_line_and_remedy) {
  const std::string head = "altitude_m,pressure_hpa,temperature_k,relative_humidity_percent\n";
  expect_error(head + "1000,900,280,50\n0,1000,288,50\n", {"p.csv:3:", "0 m after 1000", "sort"});
  expect_error(head + "0,1000,288,50\n1000,1001,280,50\n", {"pressure falls with height"});
  expect_error(head + "0,1000,15,50\n", {"15 K", "unit"});
  expect_error("altitude_m,pressure_pa,temperature_k,relative_humidity\n0,1013,288,.5\n", {"1013 Pa at 0", "unit"});
  expect_error(head + "0,101325,288,50\n", {"unit"});
  expect_error(head + "0,1000,288,120\n", {"120 %", "0 to 100 %"});
  expect_error("altitude_m,pressure_hpa,temperature_k,relative_humidity\n0,1000,288,50\n",
               {"relative_humidity_percent"});
  expect_error(head + "0,0,288,50\n", {"above 0"});
  expect_error("altitude_m,pressure_hpa,temperature_k\n0,1000,288\n", {"called relative_humidity"});
  expect_error("height,pressure_hpa,temperature_k,h2o_ppmv\n0,1000,288,1\n", {"altitude_m or altitude_km"});
  expect_error("altitude_m,altitude_km,pressure_hpa,temperature_k,h2o_ppmv\n0,0,1000,288,1\n", {"leave one"});
  expect_error("altitude_m,pressure_hpa,temperature_k,h2o_ppmv,relative_humidity\n0,1000,288,1,.1\n", {"leave one"});
  expect_error("altitude_m,pressure_hpa,temperature_k,h2o_ppmv\n0,1000,288,2e6\n", {"0 to 1e6"});
  expect_error("altitude_m,altitude_m,pressure_hpa,temperature_k,h2o_ppmv\n0,0,1000,288,1\n", {"two columns"});
}

}  // namespace
}  // namespace mtf::io
