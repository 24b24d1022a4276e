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

TEST_F(HeatLimits, SchedulesThatEndWithinTheRun) {
  const auto said = [&](const std::string& rows) {
    std::ofstream(folder_ / "engine.csv") << "time,bay (degC)\n" << rows;
    return with(warnings(weather(290, 2, 0, 0, 330),
                         painted("\"mcadams\"",
                                 "inside = { kind = \"film\", h = \"10 W/m2/K\", temperature = \"engine.csv\" }\n")),
                "engine.csv");
  };
  expect_says(
      said("2016-03-20T06:00:00Z,20\n2016-03-20T07:00:00Z,80\n"),
      {"beyond its samples the first and the last value are held", "from 2016-03-20T06:00:00Z to 2016-03-20T07:00:00Z",
       "from 2016-03-20T00:00:00Z to 2016-03-21T00:00:00Z"});
  EXPECT_EQ(said("2016-03-20T00:00:00Z,20\n2016-03-21T00:00:00Z,80\n"), "");
  EXPECT_EQ(said("2016-03-20T06:00:00Z,20\n"), "");  // a constant
}

// Pairs of squares of 1 m, 0.5 m apart and far from the other pair: what is given faces down on what is solved, whose
// view of it is that of parallel squares (Howell, A Catalog of Radiation Heat Transfer Configuration Factors, C-11).
// Facets of a table radiate as they are, above 1023 K too. 3 K: sampled views of 1e-3 at 230 kW/m2 and 260 W/m2/K.
TEST_F(HeatLimits, HotFacetsOfATableRadiateEachByItself) {
  constexpr double kView = 0.4152532835771469;
  std::string obj = plate(0.0, 1, "solved"), given = "g given\n";
  for (int i = 1; i < 4; ++i)
    for (const auto& [x, y] : {std::pair{0, 0}, std::pair{1, 0}, std::pair{1, 1}, std::pair{0, 1}})
      obj += "v " + std::to_string(400 * (i % 2) + x) + " " + std::to_string(y) + (i == 1 ? " 0\n" : " 0.5\n");
  obj += "f 5 6 7 8\n" + given + "f 9 12 11 10\nf 13 16 15 14\n";
  std::ofstream(folder_ / "hot.csv") << "facet,temperature_K\n2,1500\n3,1100\n";
  const Outcome out = run(kDay + weather(288.15, 2, 0, 0, 300) + kSky +
                              material("paint", 0.0, 0.8, "{ h0 = \"200 W/m2/K\", h1 = \"0 J/m3/K\" }") + kMesh +
                              region("solved", "material = \"paint\"") + region("given", "temperature = \"hot.csv\""),
                          obj);
  for (const auto& [facet, kelvin] : {std::pair{0, 1500.0}, std::pair{1, 1100.0}})
    EXPECT_NEAR(out.front.back()[static_cast<std::size_t>(facet)],
                equilibrium(0.8 * (kView * kSigma * std::pow(kelvin, 4) + (1.0 - kView) * 300.0), 0.8, 200.0, 288.15),
                3.0);
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
