// SPDX-License-Identifier: Apache-2.0
// What `mtf sweep` refuses, and that nothing is left of it then.

#include <gtest/gtest.h>

#include "tests/apps/study/small_study.h"
#include "tests/expect_error.h"
#include "tests/replaced.h"

namespace apps_test {
namespace {

using study_test::add_study;
using study_test::kSmallStudy;

TEST(SweepCommand, UsageErrorsSayWhatIsWrong) {
  const Scratch scratch;
  add_study(scratch);
  const std::vector<std::pair<std::string, std::string>> cases{
      {"", "study"},
      {"study.toml", "needs a folder to write; add -o FOLDER"},
      {"study.toml -o out --shards 3", "--shards: `mtf sweep` does not take it"},
      {"study.toml -o out --submit", "--submit: `mtf sweep` does not take it"},
      {"study.toml -o out --tolerance 2", "--tolerance: 2 is outside [1e-12, 0.1]"},
      {"study.toml -o out --format csv", "--format"},
      {"rum study.toml -o out", "did you mean run?"},
      {"nothing.toml -o out", "nothing.toml"},
      {"study.toml -o a/b", "there is no folder"},
      {"plan study.toml -o out", "--shards: not given"},
      {"plan study.toml -o out --shards 118", "designs (117)"},
      {"run out --shard 0/3", "--shard: '0/3' is not I/N"},
      {"run out --shard 4/3", "--shard: '4/3' is not I/N"},
      {"run out --shard 1/3", "holds no plan.json"},
      {"merge out -o merged", "holds no plan.json"},
      {"submit out --engine cloud", "slurm, parallel, local"}};
  for (const auto& [arguments, message] : cases) {
    const Result result = scratch.run("mtf sweep " + arguments);
    EXPECT_NE(result.status, 0) << arguments;
    expect_says(result.err, {message});
    EXPECT_FALSE(fs::exists(scratch / "out")) << arguments;
  }
}

TEST(SweepCommand, FilesOutsideOfTheStudysFolderAreRefused) {
  const Scratch scratch;
  add_study(scratch);
  fs::create_directory(scratch / "below");
  write_file(scratch / "below/study.toml", replaced(kSmallStudy, "sensor.toml", "../sensor.toml"));
  const Result result = scratch.run("mtf sweep below/study.toml -o out");
  EXPECT_EQ(result.status, 2);
  expect_says(result.err, {"the study's folder"});
  EXPECT_FALSE(fs::exists(scratch / "out"));  // where the corrected study would find a sweep that was stopped
}

// Whoever checks a study first learns all that the sweep would refuse, in the same words and places.
TEST(SweepCommand, RefusesTheStudiesThatTheCheckRefuses) {
  const Scratch scratch;
  scratch.add_sensor();
  for (const char* folder : {"study", "study/sub", "study/parts"}) fs::create_directory(scratch / folder);
  for (const char* file : {"study/sensor.toml", "study/designs.csv", "study/parts/sensor.toml"})
    fs::copy_file(scratch / "sensor.toml", scratch / file);
  fs::create_symlink("../sensor.toml", scratch / "study/link.toml");
  const auto head = [](const std::string& sensor) { return "schema = 1\nsensor = \"" + sensor + "\"\n"; };
  const std::string sensor = head("sensor.toml");
  const std::string axis = "[[axis]]\nparameter = \"frame.pitch\"\nvalues = [\"8 um\", \"10 um\"]\n";
  const std::string metrics = "[metrics]\nlist = [\"mtf_nyquist\"]\n", both = axis + metrics;
  const auto own = [](const std::string& name) { return "[[axis]]\nname = \"" + name + "\"\nvalues = [1.0, 2.0]\n"; };
  struct Case {
    std::string text, says;  // "" for a good study
  };
  const std::vector<Case> cases{
      {sensor + both, ""},
      {head("sub/../sensor.toml") + both, ""},
      {head("link.toml") + both, ""},
      {"schema = 1\nsensor = \"sensor.toml\n" + both, "2:"},
      {head("../sensor.toml") + both, "2:10: error: sensor: study/../sensor.toml"},
      {head("designs.csv") + both, "2:10: error: sensor: study/designs.csv"},
      {head("sub/../parts/sensor.toml") + both, "2:10: error: sensor: study/sub/../parts/sensor.toml"},
      {"schema = 1\n[[axis]]\nparameter = \"sensor\"\nvalues = [\"sensor.toml\", \"../sensor.toml\"]\n" + metrics,
       "4:26: error: axis[0].values: study/../sensor.toml lies outside"},
      {head("none.toml") + both, "2:10: error: sensor: cannot read study/none.toml"},
      {sensor + "constraints = [\"mtf_nyqist > 0.1\"]\n" + both, "3:17: error: constraints[0]: 'mtf_nyqist': "},
      {sensor + "objectives = [\"minimize netd\"]\n" + axis, "3:25: error: objectives[0]: needs netd"},
      {sensor + "tolerance = 1\n" + both, "3:13: error: tolerance: 1 is outside"},
      {sensor + both + own("error"), "9:8: error: axis[1].name: error"},
      {sensor + "constraints = [\"design > mtf_nyquist\"]\n" + axis + "[links]\ndesign = \"2\"\n",
       "8:1: error: links.design: design"},
      {sensor + "objectives = [\"minimize pareto\", \"maximize mtf_nyquist\"]\n" + both + own("pareto"),
       "pareto is a column"},
      {sensor + both + own("feasible"), ""},  // without constraints there is no such column
      {sensor + both + "[links]\na = \"b + 1\"\nb = \"a + 1\"\n", "links.a: follows from itself"},
      {sensor + "objectivs = []\n" + both, "3:1: error: objectivs: unknown key"}};
  for (std::size_t i = 0; i < cases.size(); ++i) {
    write_file(scratch / "study/one.toml", cases[i].text);
    const std::string folder = "out" + std::to_string(i);
    const Result check = scratch.run("mtf config check study/one.toml");
    const Result sweep = scratch.run("mtf sweep study/one.toml -o " + folder);
    const Result plan = scratch.run("mtf sweep plan study/one.toml --shards 2 -o plan" + std::to_string(i));
    EXPECT_EQ(check.status, cases[i].says.empty() ? 0 : 2) << cases[i].text << check.err;
    for (const Result& other : {sweep, plan}) {
      EXPECT_EQ(other.status, check.status) << cases[i].text << other.err;
      if (!cases[i].says.empty()) {
        EXPECT_EQ(other.err, check.err);
      }
    }
    expect_says(check.err, {cases[i].says});
    EXPECT_EQ(fs::exists(scratch / folder), cases[i].says.empty());
    EXPECT_EQ(fs::exists(scratch / ("plan" + std::to_string(i))), cases[i].says.empty());
  }
}

}  // namespace
}  // namespace apps_test
