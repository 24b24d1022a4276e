// SPDX-License-Identifier: Apache-2.0

// What ranges of acquisition need to know, and what they say that they hold for.

#include "apps/study/study.h"
#include "tests/apps/study/evaluated.h"
#include "tests/apps/study/range_camera.h"
#include "tests/expect_error.h"
#include "tests/replaced.h"

namespace {

using namespace study_test;

/// Why the first metric has no number, before any design or of the first.
std::string reason(const Folder& folder, const std::string& text) {
  Evaluated e = evaluated(folder, text);
  const std::vector<std::string> gaps = e.evaluator->gaps();
  for (std::size_t c = 0; c < e.columns.size(); ++c)
    if (!gaps[c].empty()) return gaps[c];
  e.at(0);
  return e.evaluator->last_refusal() + e.evaluator->last_problem();
}

void expect_reason(const Folder& folder, const std::string& text, const std::vector<std::string>& parts) {
  const std::string why = reason(folder, text);
  for (const std::string& part : parts) expect_says(why, {part});
}

TEST(Ranges, AirThatCannotBeFollowedIsRefusedWithTheRemedy) {
  const Folder folder;
  const auto with = [&](const std::string& air) { folder.write("camera.toml", camera(air)); };
  const std::string study = study_of(kTime, kConditions, "1e-4", "\"ttp_range_detect\"");
  with("[path]\ntransmission = 0.8\n");
  expect_reason(folder, study, {"holds for one range", "[atmosphere]", "path.table", "extinction"});
  folder.write("air.csv", beer_table(0.5, {2000.0}, false));
  with("[path]\ntable = \"air.csv\"\nrange = \"1 km\"\n");
  expect_reason(folder, study, {"path.table holds one range", "mtf atmosphere --table"});
  with(
      "[atmosphere]\nmodel = \"tropical\"\nsensor_altitude = \"3 km\"\ntarget_altitude = \"0 m\"\nzenith_angle = \"120 "
      "deg\"\n");
  expect_reason(folder, study, {"zenith_angle", "give range"});
  with("[[presample]]\nkind = \"turbulence\"\nlabel = \"seeing\"\nfried_parameter = \"50 mm\"\n");
  expect_reason(folder, study, {"\"seeing\"", "path of its own", "cn2"});
  const std::string depth = "[atmosphere]\nmodel = \"tropical\"\n";
  std::string by_pixel = camera(depth);
  by_pixel.replace(by_pixel.find("emissivity = 0.95"), 0, "depth_channel = \"Z\"\n");
  folder.write("camera.toml", by_pixel);
  expect_reason(folder, study, {"range of each pixel", "depth_channel"});
}

TEST(Ranges, ATaskThatSucceedsBeyondWhatIsKnownSaysWhereThatEnds) {
  const Folder folder;
  folder.write("air.csv", beer_table(0.05, {500.0, 1000.0, 2000.0}, false));
  folder.write("camera.toml", camera("[path]\ntable = \"air.csv\"\nrange = \"1 km\"\n"));
  Evaluated e = evaluated(folder, study_of(kTime));
  e.at(0);
  EXPECT_TRUE(std::isnan(e["ttp_range_detect"]));
  EXPECT_TRUE(std::isfinite(e["johnson_range_identify"]));  // at Nyquist, 1.9 km
  expect_says(e.evaluator->last_refusal(), {"johnson_range_detect", "still succeeds at 2000 m", "air.csv ends"});
  expect_says(e.evaluator->last_caution(), {"Nyquist", "johnson_range_identify"});
  // A mast of 10 m sees the ground to 11.3 km: (2 x 6371 km x 10 m)^(1/2), and a little more by refraction.
  folder.write("camera.toml", camera("[atmosphere]\nmodel = \"us_standard_1976\"\nsensor_altitude = \"10 m\"\n"
                                     "target_altitude = \"0 m\"\nrange = \"1 km\"\n"));
  expect_reason(folder, study_of(kTime, kConditions, "1e-4", "\"johnson_range_detect\""),
                {"still succeeds at 12", "the horizon"});
}

TEST(Ranges, NeedToKnowAtWhichAngleTheObserverSeesThePicture) {
  const Folder folder;
  folder.write("camera.toml", camera(""));
  std::string blind = kConditions;
  blind = replaced(blind, "magnification = 5.0\n", "");
  Evaluated e =
      evaluated(folder, study_of(kTime, blind, "1e-4", R"("ttp", "ttp_range_detect", "johnson_range_detect")"));
  const auto gaps = e.evaluator->gaps();
  for (std::size_t c = 0; c < e.columns.size(); ++c)
    if (e.columns[c].name.starts_with("ttp")) {
      expect_says(gaps[c], {"[conditions] magnification", "display_height and viewing_distance"});
    }
  e.at(0);
  EXPECT_TRUE(std::isnan(e["ttp_range_detect"]));
  EXPECT_TRUE(std::isfinite(e["johnson_range_detect"]));  // its observer has no optics
  // 200 mm at 600 mm, 512 rows of 15 um behind 150 mm: (1/3)/(7.68/150) = 6.5104. The picture is 18.92 x 23.54 degrees.
  const auto viewing = radiometry::viewing_of(
      radiometry::Conditions{.display_height_m = 0.2, .viewing_distance_m = 0.6}, e.study->base.system.frame);
  EXPECT_NEAR(viewing.magnification, 6.510416666666667, 1e-12);
  EXPECT_NEAR(viewing.field_deg, std::sqrt(18.924644416051233 * 23.536577864041288), 1e-9);
  const auto display = ranges_of(
      folder, study_of(kTime, blind + "display_height = \"200 mm\"\nviewing_distance = \"600 mm\"\n", "1e-6"));
  const auto given = ranges_of(folder, study_of(kTime, blind + "magnification = 6.510416666666667\n", "1e-6"));
  // The picture of a magnification alone has 10 degrees; in a larger one the eye sees a little more.
  EXPECT_GT(display.at("ttp_range_detect") / given.at("ttp_range_detect"), 1.01);
  EXPECT_LT(display.at("ttp_range_detect") / given.at("ttp_range_detect"), 1.1);
  folder.write("camera.toml", [&] {
    std::string text = camera("");
    return replaced(text, "format = [640, 512]\n", "");
  }());
  expect_reason(folder,
                study_of(kTime, blind + "display_height = \"200 mm\"\nviewing_distance = \"600 mm\"\n", "1e-4",
                         "\"ttp_range_detect\""),
                {"no [frame] format"});
}

TEST(Ranges, ConditionsThatContradictTheSensorOrEachOtherAreErrors) {
  const Folder folder;
  const auto told = [&](const std::string& air, const std::string& more, const std::string& axes = kTime) {
    folder.write("camera.toml", camera(air));
    std::istringstream lines(folder.lines(study_of(axes, kConditions + more, "1e-4", "\"gsd\"")));
    std::string own;  // without what the sensor file itself is warned of
    for (std::string line; std::getline(lines, line);)
      if (!says(line, "warning: sensor: ")) own += line + "\n";
    return own;
  };
  const std::string fog = kFog + "range = \"1 km\"\n";
  const auto expect = [](const std::string& text, const std::vector<std::string>& parts) {
    for (const std::string& part : parts) EXPECT_TRUE(says(text, part)) << text << "\nhas no: " << part;
  };
  EXPECT_EQ(told(fog, ""), "");
  EXPECT_EQ(told(fog, "range = \"1000 m\"\n"), "");
  expect(told(fog, "extinction = 0.2\n"),
         {"15:14: error: conditions.extinction", "[atmosphere] of camera.toml", "remove"});
  expect(told("[path]\ntransmission = 0.8\n", "extinction = 0.0\n"),
         {"conditions.extinction", "[path] of camera.toml"});
  expect(told(fog, "range = \"5 km\"\n"), {"conditions.range", "is 5000 m", "1000 m long", "give both the same"});
  expect(told(fog, "range = \"16.1 km\"\n"), {"is 16100 m, but"});  // not 16100.000000000002, as 16.1 x 1000 is
  EXPECT_EQ(told("[path]\ntransmission = 0.8\n", "range = \"5 km\"\n"), "");
  expect(told(fog, "range = \"1 km\"\n", axis("atmosphere.range", R"("1 km", "2 km")")),
         {"conditions.range", "changes the range", "remove it"});
  // From space the air is shorter than the line of sight.
  const std::string down =
      "[atmosphere]\nmodel = \"us_standard_1976\"\nsensor_altitude = \"100 km\"\n"
      "target_altitude = \"0 m\"\nrange = \"100 km\"\n";
  EXPECT_EQ(told(down, "range = \"500 km\"\n"), "");
  expect(told(down, "range = \"50 km\"\n"), {"conditions.range"});
  expect(told("", "display_height = \"0.2 m\"\nviewing_distance = \"0.6 m\"\n"),
         {"conditions.magnification", "remove one"});
  expect(folder.lines(study_of(kTime, "[conditions]\ndisplay_height = \"0.2 m\"\n")),
         {"conditions.display_height", "needs viewing_distance"});
  // One that is wrong is there: it alone is told.
  for (const char* wrong : {"display_height = \"-1 mm\"\nviewing_distance = \"0.6 m\"\n",
                            "display_height = \"0.2 m\"\nviewing_distance = \"-1 m\"\n"}) {
    const std::string lines = folder.lines(study_of(kTime, std::string("[conditions]\n") + wrong));
    expect_says(lines, {"is outside"});
    EXPECT_FALSE(says(lines, "needs")) << lines;
  }
}

// Without [conditions] range the ground sample is that at the end of the air, design by design.
TEST(Ranges, OfTheGroundSampleIsThatOfTheAir) {
  const Folder folder;
  folder.write("camera.toml", camera(kFog + "range = \"1 km\"\n"));
  Evaluated e = evaluated(folder, study_of(axis("atmosphere.range", R"("100 m", "400 m")"), kConditions, "1e-4",
                                           R"("gsd", "niirs_giqe5", "grd")"));
  for (const std::int64_t design : {0, 1}) {
    e.at(design);
    EXPECT_NEAR(e["gsd"], (design == 0 ? 0.01 : 0.04), 1e-12);
  }
  e.at(0);
  EXPECT_TRUE(std::isfinite(e["grd"]));
}

TEST(Ranges, StudiesSayWhoseTheyAre) {
  const Folder folder;
  folder.write("camera.toml", camera(kFog + "range = \"1 km\"\n"));
  const auto lines = [&](const std::string& text) { return study::condition_lines(*evaluated(folder, text).study); };
  const auto all = lines(study_of(kTime));
  ASSERT_EQ(all.size(), 7u);
  expect_says(all[0], {"observer of bars:", "ratio 2.5", "eye time 0.1 s", "60 Hz"});
  expect_says(all[1],
              {"barten_short_squared", "34.26 cd/m^2", "magnification 5", "picture of 10 deg", "5 K from dark"});
  expect_says(all[2], {"target: 2.3 m", "1 K", "300 K"});
  expect_says(all[3], {"V50 2, 7.5, 13"});
  expect_says(all[4], {"N50 0.75, 3, 6"});
  expect_says(all[5], {"Johnson's ranges end at the Nyquist frequency", "neither counts aliasing"});
  expect_says(all[6], {"air: [atmosphere] model mid_latitude_summer", "haze advection_fog", "visibility 300 m",
                       "range 1000 m", "up to each"});
  EXPECT_TRUE(lines(study_of(kTime, kConditions, "1e-4", "\"ifov\"")).empty());
  expect_says(lines(study_of(kTime, kConditions, "1e-4", "\"target_snr\"")).at(0), {"scene:", "300 K", "contrast 1 K"});
  EXPECT_EQ(lines(study_of(kTime, kConditions, "1e-4", "\"mrtd\"")).size(), 2u);  // observer and air
}

}  // namespace
