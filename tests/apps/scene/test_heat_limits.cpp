// SPDX-License-Identifier: Apache-2.0

// What models do not hold for is said once, with the first time, the place and the extreme; what has no meaning is
// refused.

#include "tests/apps/scene/heat_run_case.h"
#include "tests/expect_error.h"

namespace apps::scene {
namespace {

using namespace test;

class HeatLimits : public HeatRun {
 protected:
  /// The warnings of a run of a plate.
  std::vector<std::string> warnings(const std::string& weather_text, const std::string& rest,
                                    const std::string& sky = kSky) {
    return run(kDay + weather_text + sky + rest, plate(0.0)).report.warnings;
  }
  static std::string with(const std::vector<std::string>& texts, const std::string& part) {
    for (const std::string& text : texts)
      if (text.find(part) != std::string::npos) return text;
    return {};
  }
};

std::string painted(const std::string& convection, const std::string& rest = "") {
  return material("paint", 0.7, 0.9, convection, rest) + kMesh + region("", "material = \"paint\"");
}

TEST_F(HeatLimits, WindsBeyondAClosure) {
  std::ofstream(folder_ / "weather.csv") << "time (h),air_temperature (K),wind_speed (m/s),direct_normal "
                                            "(W/m2),diffuse_horizontal (W/m2),longwave_down (W/m2)\n"
                                            "0,290,5,0,0,330\n6,290,20,0,0,330\n12,290,60,0,0,330\n24,290,5,0,0,330\n";
  const std::string file = "[weather]\nfile = \"weather.csv\"\nbridge = \"24 h\"\n";
  // From 20 to 60 m/s in 6 h, 30 m/s is passed after 7.5 h.
  expect_says(with(warnings(file, painted("\"mcadams\"")), "convection"),
              {"convection mcadams: the wind", "0 m/s ... 30 m/s", "first at 2016-03-20T07:40:00Z", "comes to 60 m/s",
               "fitted below 5 m/s", "some 20 %"});
  EXPECT_NE(with(warnings(file, painted("\"tarp\"")), "convection tarp: the wind"), "");
  EXPECT_EQ(with(warnings(file, painted("{ h0 = \"5 W/m2/K\", h1 = \"3 J/m3/K\" }")), "convection"), "");
  EXPECT_EQ(with(warnings(weather(290, 20, 0, 0, 330), painted("\"mcadams\"")), "convection"), "");
}

TEST_F(HeatLimits, WetSurfacesBeyondTheFormulaOfSaturation) {
  const auto wet = [&](double air_k, double direct) {
    return with(warnings(weather(air_k, 0.5, direct, 50, 300) + "vapour_pressure = \"200 Pa\"\n",
                         painted("\"mcadams\"", "wet_fraction = 0.01\n")),
                "evaporation");
  };
  expect_says(wet(262.0, 0.0), {"evaporation:", "region 'plates', facet 0:", "273.15 K ... 333.15 K",
                                "first at 2016-03-20T00:00:00Z", "comes to 26"});
  expect_says(wet(310.0, 1000.0), {"above 60 degC"});
  EXPECT_EQ(wet(288.0, 0.0), "");
}

TEST_F(HeatLimits, AirOfTheSkyBeyondWhatWasFitted) {
  const std::string sky = "[sky]\nlongwave = \"atmosphere\"\n[atmosphere]\nmodel = \"mid_latitude_summer\"\n";
  const std::string hot =
      with(warnings(weather(335, 2, 0, 0, 330) + "vapour_pressure = \"115 hPa\"\n", painted("\"mcadams\""), sky),
           "[atmosphere], as the weather has it");
  expect_says(hot, {"335 K", "at 0 m"});
  EXPECT_EQ(with(warnings(weather(290, 2, 0, 0, 330) + "vapour_pressure = \"10 hPa\"\n", painted("\"mcadams\""), sky),
                 "[atmosphere]"),
            "");
}

TEST_F(HeatLimits, RefusesWhatHasNoMeaning) {
  const auto refusal = [&](const std::string& weather_text, const std::string& rest) {
    return message_of([&] { prepare(kDay + weather_text + kSky + rest, plate(0.0)); });
  };
  const std::string humid = weather(290, 2, 0, 0, 330) + "vapour_pressure = \"1000 Pa\"\n";
  expect_says(refusal(humid, painted("\"none\"", "wet_fraction = 0.5\n")), {"material 'paint'", "wet_fraction"});
  expect_says(refusal(weather(283.15, 2, 0, 0, 330) + "vapour_pressure = \"7250 Pa\"\n", painted("\"mcadams\"")),
              {"humidity of 59"});
  expect_says(refusal(weather(290, 2, 0, 1500, 330), painted("\"mcadams\"")), {"global irradiance"});
}

}  // namespace
}  // namespace apps::scene
