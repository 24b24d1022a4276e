// SPDX-License-Identifier: Apache-2.0
// `mtf sweep STUDY -o DIR`: what it leaves, what it says, what a stop costs.

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <nlohmann/json.hpp>
#include <set>

#include "tests/apps/study/small_study.h"
#include "tests/expect_error.h"
#include "tests/replaced.h"

namespace apps_test {
namespace {

using nlohmann::json;
using study_test::add_study;
using study_test::kSmallStudy;
using study_test::sampled_study;
using study_test::tables;

/// Rows of designs.npy.
std::vector<double> numbers_of(const std::string& npy) {
  const std::size_t start = npy.find('\n') + 1;
  std::vector<double> numbers((npy.size() - start) / sizeof(double));
  std::memcpy(numbers.data(), npy.data() + start, numbers.size() * sizeof(double));
  return numbers;
}

TEST(SweepCommand, LeavesAFolderThatAgreesWithItself) {
  const Scratch scratch;
  add_study(scratch);
  const Result result = scratch.run("mtf sweep study.toml -o out --accuracy");
  ASSERT_EQ(result.status, 0) << result.err;
  EXPECT_EQ(result.err, "");
  expect_says(result.out, {"pitch against jitter:", "117 designs\n", "designs/s"});
  const json sweep = json::parse(read_file(scratch / "out/sweep.json"));
  EXPECT_EQ(read_file(scratch / "out/study.toml"), kSmallStudy);
  EXPECT_EQ(read_file(scratch / "out/sensor.toml"), read_file(scratch / "sensor.toml"));
  EXPECT_FALSE(fs::exists(scratch / "out/parts"));
  ASSERT_EQ(sweep["designs"], 117);
  EXPECT_EQ(sweep["evaluated"], 117);
  EXPECT_EQ(sweep["axes"][0]["values"].size(), 13U);
  EXPECT_EQ(sweep["axes"][0]["values"][12], 20.0);
  EXPECT_EQ(sweep["accuracy"].size(), 8U);
  const std::string csv = read_file(scratch / "out/designs.csv");
  EXPECT_EQ(lines(csv), 118U);
  std::string header = "design";
  std::vector<std::string> names;
  for (const json& column : sweep["columns"]) {
    names.push_back(column["name"]);
    header += "," + names.back();
  }
  EXPECT_EQ(csv.substr(0, csv.find('\n')), header);
  // Counted once more from the numbers themselves.
  const std::vector<double> numbers = numbers_of(read_file(scratch / "out/designs.npy"));
  ASSERT_EQ(numbers.size(), 117 * names.size());
  const auto column = [&](const std::string& name) {
    return static_cast<std::size_t>(std::find(names.begin(), names.end(), name) - names.begin());
  };
  const auto at = [&](std::size_t design, const std::string& name) {
    return numbers[design * names.size() + column(name)];
  };
  std::int64_t feasible = 0, sharp = 0, small = 0, best = -1;
  for (std::size_t d = 0; d < 117; ++d) {
    const bool one = at(d, "mtf_nyquist") > 0.1, two = at(d, "frame.pitch") <= 18.0;
    sharp += one ? 1 : 0;
    small += two ? 1 : 0;
    EXPECT_EQ(at(d, "feasible"), one && two ? 1.0 : 0.0) << d;
    if (!one || !two) continue;
    ++feasible;
    if (best < 0 || at(d, "mtf_nyquist") > at(static_cast<std::size_t>(best), "mtf_nyquist"))
      best = static_cast<std::int64_t>(d);
  }
  EXPECT_EQ(sweep["feasible"], feasible);
  EXPECT_GT(feasible, 0);
  EXPECT_EQ(sweep["constraints"][0]["met"], sharp);
  EXPECT_EQ(sweep["constraints"][1]["met"], small);
  ASSERT_EQ(sweep["best"].size(), 2U);
  EXPECT_EQ(sweep["best"][0]["design"], best);
  EXPECT_EQ(sweep["best"][0]["value"], at(static_cast<std::size_t>(best), "mtf_nyquist"));
  for (const json& design : sweep["pareto"]) {
    const std::size_t d = design;
    for (std::size_t other = 0; other < 117; ++other)
      if (at(other, "feasible") == 1.0) {
        EXPECT_FALSE(at(other, "mtf_nyquist") >= at(d, "mtf_nyquist") &&
                     at(other, "frame.pitch") < at(d, "frame.pitch"))
            << other << " beats " << d;
      }
  }
  ASSERT_FALSE(sweep["chosen"].empty());
  for (const json& chosen : sweep["chosen"]) {
    const Result check = scratch.run("mtf config check out/" + std::string(chosen["file"]));
    EXPECT_EQ(check.status, 0) << check.out << check.err;
  }
}

/// Texts of limits that hold the goal back: with a gain, where that is known.
std::set<std::string> texts_of(const json& limits) {
  std::set<std::string> texts;
  for (const json& limit : limits)
    if (limit["gain"].is_null() || limit["gain"] > 0.0)
      texts.insert(std::string(limit["text"]) + ", " + std::string(limit["kind"]));
  return texts;
}

// The grid and the search between its designs, by slopes, name the same limits in the same words, also where the best
// design of the grid is further than 1 % from all of them. The page says them, with the design and the conditions.
TEST(SweepCommand, TheLimitsOfTheBestDesignsAreThoseOfOptimize) {
  const Scratch scratch;
  fs::copy_file(MTFKIT_SOURCE_DIR "/notebooks-data/studies/mwir_cooled.toml", scratch / "camera.toml");
  write_file(scratch / "study.toml", R"toml(schema = 1
sensor = "camera.toml"
constraints = ["mass < 1.5 kg", "netd < 40 mK"]
objectives = ["maximize ttp_range_recognise", "minimize mass"]
axis = [{ name = "lens", from = "30 mm", to = "120 mm", count = 7 }, { parameter = "frame.pitch", from = "6 um", to = "20 um", count = 8 }]
links = { focal_length = "lens * f_number", mass = "(0.5 kg) + (1 kg) * (lens / (90 mm)) ^ 3" }
conditions = { contrast = "1 K", target_size = "2.3 m", frame_rate = "60 Hz", magnification = 5.0, extinction = 0.2 }
)toml");
  const Result result = scratch.run("mtf sweep study.toml -o out && mtf report out");
  ASSERT_EQ(result.status, 0) << result.err;
  const json sweep = json::parse(read_file(scratch / "out/sweep.json"));
  const Result optimized = scratch.run("mtf optimize study.toml --each --starts 2 --format json");
  ASSERT_EQ(optimized.status, 0) << optimized.err;
  const json goals = json::parse(optimized.out)["goals"];
  const std::string page = read_file(scratch / "out/report.html");
  for (std::size_t o = 0; o < 2; ++o) {
    const json& best = sweep["best"][o];
    EXPECT_EQ(texts_of(best["limits"]), texts_of(goals[o]["best"]["limits"])) << o;
    for (const json& limit : best["limits"]) {
      const std::string text = limit["text"], sign = text.find('<') != std::string::npos ? "<" : ">";
      expect_says(page,
                  {replaced(text, sign, sign == "<" ? "&lt;" : "&gt;") + "</strong> (" + std::string(limit["state"])});
    }
  }
  expect_says(page, {"&nbsp;km</strong> is the", "&nbsp;kg", "&nbsp;mK", "2.3 m, 1 K warmer", "0.2 per km",
                     std::string(sweep["date"])});
}

// The front is a column of both tables and a short table on the terminal; columns.csv has the unit of every column.
TEST(SweepCommand, TheFrontIsMarkedAndTheColumnsAreDescribed) {
  const Scratch scratch;
  add_study(scratch, replaced(kSmallStudy, "count = 13", "count = 49"));
  const Result result = scratch.run("mtf sweep study.toml -o out");
  ASSERT_EQ(result.status, 0) << result.err;
  const json sweep = json::parse(read_file(scratch / "out/sweep.json"));
  const json& columns = sweep["columns"];
  EXPECT_EQ(columns.back()["name"], "pareto");
  EXPECT_EQ(columns.back()["role"], "pareto");
  const std::vector<double> numbers = numbers_of(read_file(scratch / "out/designs.npy"));
  ASSERT_EQ(numbers.size(), 441 * columns.size());
  std::vector<std::int64_t> marked;
  for (std::size_t d = 0; d < 441; ++d) {
    const double mark = numbers[(d + 1) * columns.size() - 1];
    EXPECT_TRUE(mark == 0.0 || mark == 1.0) << d;
    if (mark == 1.0) marked.push_back(static_cast<std::int64_t>(d));
  }
  EXPECT_EQ(json(marked), sweep["pareto"]);
  const std::size_t size = marked.size();
  ASSERT_GT(size, 12U);
  expect_says(result.out, {"Pareto front: " + std::to_string(size) +
                               " designs\ndesign  mtf_nyquist  frame.pitch [um]  jitter.rms [um]\n",
                           "\nand " + std::to_string(size - 10) + " more", "column pareto of designs.csv"});
  std::string described = "column,unit,definition\ndesign,,\"number of the design, from 0\"\n";
  const std::string csv = read_file(scratch / "out/columns.csv");
  EXPECT_TRUE(csv.starts_with(described)) << csv;
  EXPECT_EQ(lines(csv), columns.size() + 2);
  for (const json& column : columns)
    expect_says(csv, {"\n" + std::string(column["name"]) + "," + std::string(column["unit"]) + ","});

  write_file(scratch / "study.toml", replaced(kSmallStudy, ", \"minimize frame.pitch\"]", "]"));
  const Result one = scratch.run("mtf sweep study.toml -o one");
  EXPECT_FALSE(says(one.out, "Pareto")) << one.out;
  EXPECT_FALSE(says(read_file(scratch / "one/designs.csv"), "pareto"));
}

TEST(SweepCommand, TheReportHasElasticitiesAndNoEmptyChartOfErrors) {
  const Scratch scratch;
  add_study(scratch, replaced(kSmallStudy, "\"mtf_nyquist_x\"]", "\"rer\"]"));
  const std::string axis = "[[axis]]\nparameter = \"frame.pitch\"\nvalues = [\"8 um\", \"10 um\"]\n";
  write_file(scratch / "exact.toml", "schema = 1\nsensor = \"sensor.toml\"\nobjectives = [\"maximize ifov\"]\n" + axis);
  for (const std::string name : {"study", "exact"}) {
    const Result result = scratch.run("mtf sweep " + name + ".toml -o " + name + " --accuracy && mtf report " + name +
                                      " -o " + name + ".html");
    ASSERT_EQ(result.status, 0) << result.err;
  }
  const std::string page = read_file(scratch / "study.html"), exact = read_file(scratch / "exact.html");
  expect_says(page, {"Change of a metric", "<figure class=\"chart\" id=\"accuracy\""});
  EXPECT_FALSE(says(exact, "id=\"accuracy\""));
  expect_says(exact, {"No metric of this"});
}

TEST(SweepCommand, TheErrorAgainstTimeIsMeasuredWhereItIsAskedFor) {
  const Scratch scratch;
  add_study(scratch);
  const Result result = scratch.run("mtf sweep study.toml -o out");
  ASSERT_EQ(result.status, 0) << result.err;
  EXPECT_FALSE(json::parse(read_file(scratch / "out/sweep.json")).contains("accuracy"));
  EXPECT_FALSE(says(result.out, "accuracy")) << result.out;
  expect_error(scratch.run("mtf sweep plan study.toml -o plan --shards 2 --accuracy"), 2,
               {"--accuracy: `mtf sweep plan`"});
}

// What a sensor lacks is an error of the study where it is asked to be best; where it is only listed the check fails,
// while a sweep leaves the column empty and says why.
TEST(SweepCommand, AGoalThatNoDesignCanHaveIsRefusedByTheCheck) {
  const Scratch scratch;
  scratch.add_sensor();
  const std::string axis = "[[axis]]\nparameter = \"frame.pitch\"\nvalues = [\"8 um\", \"10 um\"]\n";
  const std::string head = "schema = 1\nsensor = \"sensor.toml\"\n";
  const auto check = [&](const std::string& text) {
    write_file(scratch / "study.toml", text);
    const Result result = scratch.run("mtf config check study.toml");
    return std::pair(result.status, result.out + result.err);
  };
  const std::vector<std::pair<std::string, std::string>> cases{
      {"objectives = [\"maximize gsd\"]\n", "no [conditions] range"},
      {"objectives = [\"minimize frame.pitch\"]\nconstraints = [\"spurious_response < 1\"]\n", "eye in [[postsample]]"},
      {"objectives = [\"minimize gsd / niirs_giqe5\"]\n", "needs niirs_giqe5"}};
  for (const auto& [goals, says] : cases) {
    const auto [status, text] = check(head + goals + axis);
    EXPECT_EQ(status, 2) << text;
    expect_says(text, {says});
  }
  const auto [status, text] = check(head + axis + "[metrics]\nlist = [\"gsd\", \"mtf50\", \"netd\"]\n");
  EXPECT_EQ(status, 2);
  expect_says(text, {"no [conditions] range, such as range = ", "no [detector]"});
  EXPECT_FALSE(says(text, "mtf50")) << text;
  const Result swept = scratch.run("mtf sweep study.toml -o out");
  EXPECT_EQ(swept.status, 0) << swept.err;
  expect_says(swept.out, {"no gsd: no [conditions] range", "no netd: no [detector]"});
}

// A design at a pole of an objective or of a constraint wins nothing: it is invalid, counted and named.
TEST(SweepCommand, InfinitiesAreInvalidAndNeverBest) {
  const Scratch scratch;
  scratch.add_sensor();
  const std::string axis =
      "[[axis]]\nparameter = \"frame.pitch\"\nvalues = [\"8 um\", \"10 um\", \"12 um\", \"14 um\"]\n"
      "[metrics]\nlist = [\"mtf_nyquist\"]\n";
  const std::string head = "schema = 1\nsensor = \"sensor.toml\"\n";
  write_file(scratch / "study.toml", head +
                                         "objectives = [\"maximize 1 / (frame.pitch / (10 um) - 1)\", "
                                         "\"maximize mtf_nyquist / 0\"]\n" +
                                         axis);
  Result result = scratch.run("mtf sweep study.toml -o pole");
  EXPECT_EQ(result.status, 3) << result.err;  // there is no result
  expect_says(result.err, {"every design is invalid"});
  EXPECT_FALSE(fs::exists(scratch / "pole/chosen"));
  expect_says(result.out, {"invalid 4 of 4", "design 0\n", "1 / (frame.pitch", "finite: 1\n",
                           "mtf_nyquist / 0 is not finite: 4\n"});
  json sweep = json::parse(read_file(scratch / "pole/sweep.json"));
  EXPECT_EQ(sweep["feasible"], 0);
  EXPECT_TRUE(sweep["best"].empty());
  EXPECT_TRUE(sweep["chosen"].empty());
  EXPECT_EQ(sweep["invalid"]["designs"], 4);
  EXPECT_EQ(sweep["invalid"]["not_finite"].size(), 2U);
  EXPECT_FALSE(says(read_file(scratch / "pole/designs.csv"), "inf"));
  const Result report = scratch.run("mtf report pole -o pole.html");
  EXPECT_EQ(report.status, 0) << report.err;
  expect_says(read_file(scratch / "pole.html"), {"mtf_nyquist / 0 not finite in 4"});

  write_file(scratch / "study.toml", head +
                                         "constraints = [\"1 / (frame.pitch / (10 um) - 1) > 0\"]\n"
                                         "objectives = [\"minimize frame.pitch\"]\n" +
                                         axis);
  result = scratch.run("mtf sweep study.toml -o limit");
  ASSERT_EQ(result.status, 0) << result.err;
  sweep = json::parse(read_file(scratch / "limit/sweep.json"));
  EXPECT_EQ(sweep["feasible"], 2);
  EXPECT_EQ(sweep["constraints"][0]["met"], 2);
  EXPECT_EQ(sweep["best"][0]["design"], 2);
  EXPECT_EQ(sweep["invalid"]["first"], 1);
}

// Designs that no sensor can be are nearest to nothing.
TEST(SweepCommand, OfInvalidDesignsNoneIsNearest) {
  const Scratch scratch;
  scratch.add_sensor();
  write_file(scratch / "study.toml",
             "schema = 1\nsensor = \"sensor.toml\"\nconstraints = [\"mtf_nyquist > 0.1\"]\n"
             "objectives = [\"maximize mtf_nyquist\"]\n[[axis]]\nparameter = \"frame.pitch\"\n"
             "values = [\"8 um\", \"10 um\"]\n[links]\n\"jitter.rms\" = \"-frame.pitch\"\n");
  const Result result = scratch.run("mtf sweep study.toml -o none");
  EXPECT_EQ(result.status, 3) << result.out << result.err;
  EXPECT_FALSE(says(result.out, "nearest")) << result.out;
  expect_says(result.out,
              {"as a sensor: 2", "the commonest cause, of 2 of 2 looked at: jitter.rms = -8 um is outside"});
  EXPECT_FALSE(fs::exists(scratch / "none/chosen"));
  EXPECT_FALSE(json::parse(read_file(scratch / "none/sweep.json")).contains("nearest"));
  EXPECT_EQ(scratch.run("mtf report none -o none.html").status, 0);
  expect_says(read_file(scratch / "none.html"),
              {"2 are invalid; the commonest cause, of 2 of the 2 that were looked at: jitter.rms = -8 um"});
}

TEST(SweepCommand, TheTablesAreTheSameForAnyThreads) {
  const Scratch scratch;
  add_study(scratch, sampled_study(600, 3));
  for (const char* threads : {"1", "2", "5"})
    ASSERT_EQ(scratch.run(std::string("mtf sweep study.toml -o t") + threads + " --threads " + threads).status, 0);
  EXPECT_EQ(tables(scratch, "t1"), tables(scratch, "t2"));
  EXPECT_EQ(tables(scratch, "t1"), tables(scratch, "t5"));
}

TEST(SweepCommand, AFinishedFolderIsReplacedByForceOnly) {
  const Scratch scratch;
  add_study(scratch);
  ASSERT_EQ(scratch.run("mtf sweep study.toml -o out").status, 0);
  expect_error(scratch.run("mtf sweep study.toml -o out"), 2, {"out is not empty"});
  ASSERT_EQ(scratch.run("mtf sweep study.toml -o out --force --tolerance 1e-3").status, 0);
  EXPECT_EQ(json::parse(read_file(scratch / "out/sweep.json"))["tolerance"], 1e-3);
}

TEST(SweepCommand, SaysWhichConstraintsContradict) {
  const Scratch scratch;
  add_study(scratch, replaced(replaced(kSmallStudy, "> 0.1", "> 0.0001"), "\"frame.pitch <= 18 um\"",
                              "\"frame.pitch < 9 um\", \"frame.pitch > 19 um\""));
  const Result result = scratch.run("mtf sweep study.toml -o out --format json");
  ASSERT_EQ(result.status, 0) << result.err;
  const json sweep = json::parse(result.out);
  EXPECT_EQ(result.out, read_file(scratch / "out/sweep.json"));
  EXPECT_EQ(sweep["feasible"], 0);
  EXPECT_EQ(sweep["contradictions"], json::parse(R"([["frame.pitch < 9 um", "frame.pitch > 19 um"]])"));
  EXPECT_GE(sweep["nearest"]["violated"].size(), 1U);
  EXPECT_TRUE(sweep["best"].empty());
  EXPECT_EQ(sweep["chosen"][0]["why"], "nearest to the constraints");
  const Result table = scratch.run("mtf sweep study.toml -o out2");
  expect_says(table.out, {"no design meets", "frame.pitch < 9 um", "frame.pitch > 19 um"});
}

TEST(SweepCommand, AStudyNamedLikeAVerbIsGivenByItsPath) {
  const Scratch scratch;
  add_study(scratch);
  fs::rename(scratch / "study.toml", scratch / "plan");
  expect_error(scratch.run("mtf sweep plan -o out"), 2, {"is given as ./plan"});
  EXPECT_EQ(scratch.run("mtf sweep ./plan -o out").status, 0);
}

}  // namespace
}  // namespace apps_test
