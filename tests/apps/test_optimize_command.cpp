// SPDX-License-Identifier: Apache-2.0

// `mtf optimize`: what is written, and what programs rely on.

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "tests/apps/command.h"

namespace apps_test {
namespace {

using Json = nlohmann::json;

/// Pitch and focal length of the starter sensor; GSD = pitch x 10 km / focal length.
void add_study(const Scratch& scratch, const std::string& constraints, const std::string& objectives) {
  scratch.add_sensor();
  write_file(scratch / "study.toml",
             "schema = 1\nname = \"small\"\nsensor = \"sensor.toml\"\nconstraints = [" + constraints +
                 "]\nobjectives = [" + objectives +
                 "]\n[[axis]]\nparameter = \"frame.pitch\"\nfrom = \"8 um\"\nto = \"20 um\"\ncount = 5\n"
                 "[[axis]]\nparameter = \"focal_length\"\nfrom = \"50 mm\"\nto = \"200 mm\"\ncount = 5\n"
                 "[metrics]\nlist = [\"mtf_nyquist\"]\n[conditions]\nrange = \"10 km\"\n");
}

double value_of(const Json& best, const std::string& name) {
  for (const Json& number : best.at("design"))
    if (number.at("name") == name) return number.at("value").get<double>();
  ADD_FAILURE() << "no " << name;
  return 0.0;
}

// The finest pitch gives the shortest lens for 1 m: 8 um x 10 km / 1 m = 80 mm.
TEST(OptimizeCommand, WritesSensorTableAndReport) {
  const Scratch scratch;
  add_study(scratch, "\"gsd <= 1 m\"", "\"minimize focal_length\"");
  const Result result = scratch.run("mtf optimize study.toml -o best.toml --report best.json --threads 2");
  ASSERT_EQ(result.status, 0) << result.err;
  EXPECT_EQ(result.err, "");
  expect_says(result.out, {"gsd <= 1 m limits", "0.01 m", "focal_length by 0.8 mm", "at its lower end"});
  const Json json = Json::parse(read_file(scratch / "best.json"));
  const Json& goal = json.at("goals").at(0);
  EXPECT_EQ(goal.at("status"), "optimal");
  EXPECT_NEAR(value_of(goal.at("best"), "focal_length"), 80.0, 1e-4);
  EXPECT_EQ(value_of(goal.at("best"), "frame.pitch"), 8.0);
  EXPECT_EQ(goal.at("file"), "best.toml");
  // The sensor that was written has the metrics that were promised.
  EXPECT_EQ(scratch.run("mtf config check best.toml").status, 0);
  const Json curve = Json::parse(scratch.run("mtf curve best.toml --freq 0.5 --unit cy/px --format json").out);
  EXPECT_NEAR(curve.at("system").at("re")[0].get<double>(), value_of(goal.at("best"), "mtf_nyquist"), 1e-5);
  EXPECT_EQ(Json::parse(scratch.run("mtf optimize study.toml --format json --threads 1").out).at("goals")[0].at("best"),
            goal.at("best"));
}

TEST(OptimizeCommand, NoFeasibleDesignIsExitCode3) {
  const Scratch scratch;
  add_study(scratch, "\"gsd <= 0.1 m\", \"focal_length <= 90 mm\"", "\"maximize mtf_nyquist\"");
  const Result result = scratch.run("mtf optimize study.toml -o best.toml");
  EXPECT_EQ(result.status, 3) << result.err;
  expect_says(result.out, {"contradict", "gsd <= 0.1 m", "focal_length <= 90 mm"});
  expect_says(result.err, {"best.toml is not written"});
  EXPECT_FALSE(std::filesystem::exists(scratch / "best.toml"));
}

TEST(OptimizeCommand, SeveralObjectives) {
  const Scratch scratch;
  add_study(scratch, "\"gsd <= 1 m\"", "\"minimize focal_length\", \"maximize frame.pitch\"");
  const Result asked = scratch.run("mtf optimize study.toml");
  EXPECT_EQ(asked.status, 2);
  expect_says(asked.err, {"--objective", "--weights", "--each", "2: maximize frame.pitch"});
  const Result each = scratch.run("mtf optimize study.toml --each -o best --format json");
  ASSERT_EQ(each.status, 0) << each.err;
  const Json json = Json::parse(each.out);
  EXPECT_EQ(value_of(json.at("goals")[1].at("best"), "frame.pitch"), 20.0);
  EXPECT_TRUE(std::filesystem::exists(scratch / "best" / "best-2.toml"));
  // 10 mm of lens are worth 1 um: focal_length = 10 pitch, so that 1 against 11 goes to the largest pitch.
  const Result weighed = scratch.run("mtf optimize study.toml --weights 1,11 --format json");
  ASSERT_EQ(weighed.status, 0) << weighed.err;
  const Json best = Json::parse(weighed.out).at("goals")[0].at("best");
  EXPECT_NEAR(value_of(best, "frame.pitch"), 20.0, 1e-9);
  EXPECT_NEAR(value_of(best, "focal_length"), 200.0, 1e-3);
}

// The report would replace a design.
TEST(OptimizeCommand, AReportThatIsADesignIsRefused) {
  const Scratch scratch;
  add_study(scratch, "\"gsd <= 1 m\"", "\"minimize focal_length\", \"maximize frame.pitch\"");
  ASSERT_EQ(scratch.run("mkdir best; ln -s best/best-2.toml report.json; ln -s x.toml y.json").status, 0);
  for (const char* outputs : {"--each -o best --report report.json", "--objective 1 -o x.toml --report y.json"}) {
    const Result result = scratch.run(std::string("mtf optimize study.toml ") + outputs);
    EXPECT_EQ(result.status, 2) << outputs << result.err;
    EXPECT_FALSE(std::filesystem::exists(scratch / "x.toml"));
  }
}

TEST(OptimizeCommand, BadRequests) {
  const Scratch scratch;
  add_study(scratch, "\"gsd <= 1 m\"", "\"minimize focal_length\", \"maximize frame.pitch\"");
  const auto refused = [&](const std::string& arguments, const std::string& word) {
    const Result result = scratch.run("mtf optimize study.toml " + arguments);
    EXPECT_EQ(result.status, 2) << arguments << result.err;
    EXPECT_TRUE(says(result.err, word)) << arguments << result.err;
  };
  refused("--objective 3", "2 objectives");
  refused("--weights 1", "1 weights for 2");
  refused("--weights 1,x", "--weights");
  refused("--each --objective 1", "exclude each other");
  refused("--starts 0", "--starts");
  refused("--method fast", "smooth, search");
  refused("--objective 1 -o sensor.toml", "sensor.toml");
  write_file(scratch / "study.toml", read_file(scratch / "study.toml").replace(0, 10, "schema = 9"));
  refused("--each", "study.toml:1:");
}

}  // namespace
}  // namespace apps_test
