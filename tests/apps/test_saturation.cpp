// SPDX-License-Identifier: Apache-2.0

// A full well or a clipped converter is said: by `mtf budget` in place of its figures, by `mtf simulate` beside its
// image. The camera is that of `mtf demo`, which fills half of its well in 2 ms at 288 K.

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "tests/apps/command.h"

namespace apps_test {
namespace {

using Json = nlohmann::json;

class SaturatedCamera : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    demo = std::make_unique<Scratch>();
    ASSERT_EQ(demo->run("mtf demo -o d").status, 0);
  }
  static void TearDownTestSuite() { demo.reset(); }

  /// camera.toml with other texts as NAME.
  static void camera(const std::string& name,
                     std::initializer_list<std::pair<std::string_view, std::string_view>> changes) {
    std::string text = read_file(*demo / "d/camera.toml");
    for (const auto& [from, to] : changes) {
      ASSERT_NE(text.find(from), std::string::npos) << from;
      text.replace(text.find(from), from.size(), to);
    }
    write_file(*demo / name, text);
  }
  static Json report(const std::string& name) { return Json::parse(read_file(*demo / name)); }
  static std::unique_ptr<Scratch> demo;
};
std::unique_ptr<Scratch> SaturatedCamera::demo;

constexpr std::pair<std::string_view, std::string_view> kNoCorrection{"[correction]", "[agc]\n#"},
    kFrames{"frames = 8", ""}, k4ms{"\"2 ms\"", "\"4 ms\""}, k20ms{"\"2 ms\"", "\"20 ms\""};

TEST_F(SaturatedCamera, TheBudgetRefusesItsFiguresAndKeepsWhatIsTrue) {
  camera("4ms.toml", {k4ms});
  const Result json = demo->run("mtf budget 4ms.toml --temperature 288 --format json");
  ASSERT_EQ(json.status, 0);
  expect_says(json.err, {"warning: saturated"});
  const Json budget = Json::parse(json.out);
  EXPECT_EQ(budget["saturation"]["saturated"], true);
  EXPECT_EQ(budget["saturation"]["end"], "full_well");
  expect_says(budget["saturation"]["reason"].get<std::string>(), {"less than 0.91"});  // 1 / 1.0927
  const Json& terms = budget["terms"];
  for (const char* name : {"snr", "netd", "shot_netd", "spatial_netd", "nei", "dstar", "temporal"}) {
    EXPECT_TRUE(terms[name]["value"].is_null()) << name;
    EXPECT_TRUE(says(terms[name]["reason"].get<std::string>(), "saturated")) << name;
  }
  EXPECT_NEAR(terms["well_fill"]["value"].get<double>(), 1.0927, 1e-4);
  EXPECT_EQ(terms["read"]["value"], 150.0);
  EXPECT_FALSE(terms["read"].contains("reason"));
  const std::string table = demo->run("mtf budget 4ms.toml --temperature 288").out;
  expect_says(table, {"\n  netd             saturated  mK", "\nsaturated: 100 %", "full well of 2e+06"});
  const std::string csv = demo->run("mtf budget 4ms.toml --temperature 288 --format csv").out;
  expect_says(csv, {"term,value,unit,doc,reason\n", "snr,,,scene / temporal noise,\"saturated"});
}

TEST_F(SaturatedCamera, TheBudgetSeesBothEndsOfTheConverter) {
  for (const auto& [adc, end, change] :
       {std::tuple{"bits = 14\nelectrons_per_count = \"50 e-\"", "most_count", "raise adc.electrons_per_count"},
        {"bits = 14\noffset = -30000", "least_count", "raise adc.offset"}}) {
    camera("adc.toml", {{"bits = 14", adc}});
    const Json budget = Json::parse(demo->run("mtf budget adc.toml --temperature 288 --format json").out);
    EXPECT_EQ(budget["saturation"]["end"], end);
    EXPECT_TRUE(budget["terms"]["netd"]["value"].is_null());
    expect_says(budget["terms"]["netd"]["reason"].get<std::string>(), {change});
    EXPECT_GT(budget["terms"]["scene"]["value"], 7e5);
  }
}

TEST_F(SaturatedCamera, ABudgetCloseToAnEndHasANote) {
  camera("near.toml", {{"\"2 ms\"", "\"3.6 ms\""}});  // 0.983 of the well; pixels differ by 2 %
  const Result near = demo->run("mtf budget near.toml --temperature 288 --format json");
  const Json budget = Json::parse(near.out);
  EXPECT_EQ(budget["saturation"]["saturated"], false);
  expect_says(budget["saturation"]["note"].get<std::string>(), {"near saturation"});
  expect_says(near.err, {"note: near saturation"});
  EXPECT_TRUE(budget["terms"]["netd"]["value"].is_number());
  const Result fine = demo->run("mtf budget d/camera.toml --temperature 288 --format json");
  EXPECT_FALSE(says(fine.err, "saturation")) << fine.err;
  EXPECT_FALSE(Json::parse(fine.out)["saturation"].contains("note"));
}

TEST_F(SaturatedCamera, SimulateWarnsWithTheShareAndTheSetting) {
  camera("20ms.toml", {k20ms, kNoCorrection, kFrames});
  const Result r = demo->run("mtf simulate 20ms.toml d/thermal.exr -o full.exr --tap dn --report r.json");
  ASSERT_EQ(r.status, 0) << r.err;
  expect_says(r.err, {"warning: saturated: 100 %", "frame.integration_time"});
  const Json json = report("r.json"), &saturation = json["chain"]["saturation"];
  EXPECT_EQ(saturation["share"], 1.0);
  EXPECT_EQ(saturation["at_full_well"], saturation["pixels"]);
  expect_says(json["warnings"].back().get<std::string>(), {"saturated"});
  // Dead pixels are none of them.
  EXPECT_GT(saturation["defective_or_blinking"]["pixels"], 0);
  EXPECT_EQ(saturation["defective_or_blinking"]["at_full_well"], 0);
  const Result one =
      demo->run("mtf simulate 20ms.toml d/thermal.exr -o one.exr --tap dn --report one.json --threads 1");
  EXPECT_EQ(report("one.json")["chain"]["saturation"], saturation);
}

TEST_F(SaturatedCamera, SimulateIsSilentWhereOnlyDefectsAreStuck) {
  camera("hot.toml",
         {{"\"2 Me-\"", "\"1000 Me-\""}, {"dead_fraction = 0.0005", "hot_fraction = 0.001\nhot = \"50000 Me-\""}});
  const Result r = demo->run("mtf simulate hot.toml d/thermal.exr -o hot.exr --report hot.json");
  ASSERT_EQ(r.status, 0) << r.err;
  EXPECT_FALSE(says(r.err, "saturated")) << r.err;
  const Json saturation = report("hot.json")["chain"]["saturation"];
  EXPECT_EQ(saturation["share"], 0.0);
  EXPECT_TRUE(saturation["warning"].is_null());
  EXPECT_GT(saturation["defective_or_blinking"]["at_full_well"], 10);
}

TEST_F(SaturatedCamera, ASequenceCountsFrameByFrame) {
  camera("s.toml", {{"\"2 Me-\"", "\"1000 Me-\""}, kNoCorrection, kFrames});
  write_file(*demo / "plan.csv", "frame,parameter,value\n2,detector.full_well,20 ke-\n4,detector.full_well,1000 Me-\n");
  const Result r = demo->run(
      "mtf simulate s.toml d/thermal.exr -o f.%d.exr --tap dn --schedule plan.csv --frames 1:4 --report s.json");
  ASSERT_EQ(r.status, 0) << r.err;
  expect_says(r.err, {"warning: 2 of 4", "in 2: saturated: 100"});
  const Json json = report("s.json"), &frames = json["sequence"]["saturated_frames"];
  ASSERT_EQ(frames.size(), 2U);
  EXPECT_EQ(frames[0]["frame"], 2);
  EXPECT_EQ(frames[1]["frame"], 3);
  EXPECT_EQ(frames[0]["at_full_well"], frames[0]["pixels"]);
  EXPECT_EQ(json["chain"]["saturation"]["at_full_well"], 2 * frames[0]["pixels"].get<int>());
  EXPECT_EQ(json["chain"]["pixels_at_full_well"], 2 * frames[0]["pixels"].get<int>());
  EXPECT_NEAR(json["chain"]["saturation"]["share"].get<double>(), 0.5, 1e-12);
}

TEST_F(SaturatedCamera, TheCorrectionNamesTheCause) {
  camera("c.toml", {k20ms});
  const Result r = demo->run("mtf simulate c.toml d/thermal.exr -o c.exr");
  EXPECT_EQ(r.status, 2);
  expect_says(r.err, {"[correction]", "fill 0.714 of it", "frame.integration_time", "to less than 0.28",
                      "saturated too: 100 %"});
  EXPECT_FALSE(fs::exists(*demo / "c.exr"));
}

}  // namespace
}  // namespace apps_test
