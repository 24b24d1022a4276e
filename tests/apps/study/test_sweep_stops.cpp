// SPDX-License-Identifier: Apache-2.0
// `mtf sweep STUDY -o DIR` stopped at every stage, and the same command again.

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

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

/// Stops a sweep after its third piece; returns the exit code of the command.
int stopped(const Scratch& scratch, const std::string& signal) {
  const Result result = scratch.run(
      "mtf sweep study.toml -o out --threads 1 & pid=$!\n"
      "for i in $(seq 3000); do [ $(ls out/parts 2>/dev/null | wc -l) -ge 4 ] && break; sleep 0.01; done\n"
      "kill -" +
      signal + " $pid; wait $pid");
  EXPECT_TRUE(fs::exists(scratch / "out/parts/key")) << "it was faster than the signal";
  EXPECT_FALSE(fs::exists(scratch / "out/sweep.json"));
  return result.status;
}

TEST(SweepCommand, AStoppedRunGoesOnAndGivesTheSameBytes) {
  for (const std::string signal : {"KILL", "INT"}) {
    const Scratch scratch;
    add_study(scratch, sampled_study(4096, 20));
    ASSERT_EQ(scratch.run("mtf sweep study.toml -o whole").status, 0);
    EXPECT_EQ(stopped(scratch, signal), signal == "INT" ? 130 : 137);
    const Result again = scratch.run("mtf sweep study.toml -o out");
    ASSERT_EQ(again.status, 0) << again.err;
    expect_says(again.err, {"which is continued"});
    const json timing = json::parse(read_file(scratch / "out/sweep.json"))["timing"];
    EXPECT_GE(timing["resumed_designs"], 16);
    EXPECT_LT(timing["resumed_designs"], 4096);
    EXPECT_EQ(tables(scratch, "out"), tables(scratch, "whole"));
    EXPECT_FALSE(fs::exists(scratch / "out/parts"));
  }
}

json without_timing(const fs::path& file) {
  json sweep = json::parse(read_file(file));
  sweep.erase("timing");
  sweep.erase("accuracy");
  return sweep;
}

// All rows are there, and the run ends before its last file is: --accuracy takes seconds after the tables are written.
TEST(SweepCommand, AStopBetweenTheLastRowAndTheLastFileGoesOnToTheSameBytes) {
  const Scratch scratch;
  add_study(scratch, replaced(kSmallStudy, "\"mtf_nyquist_x\"]", "\"rer\", \"mtfa\"]"));
  ASSERT_EQ(scratch.run("mtf sweep study.toml -o whole").status, 0);
  const auto expect_whole = [&](const std::string& folder) {
    EXPECT_EQ(tables(scratch, folder), tables(scratch, "whole"));
    EXPECT_EQ(read_file(scratch / (folder + "/columns.csv")), read_file(scratch / "whole/columns.csv"));
    EXPECT_EQ(without_timing(scratch / (folder + "/sweep.json")), without_timing(scratch / "whole/sweep.json"));
    EXPECT_EQ(scratch.run("diff -r whole/chosen " + folder + "/chosen").status, 0);
    EXPECT_FALSE(fs::exists(scratch / (folder + "/parts")));
  };
  for (const std::string signal : {"KILL", "INT"})
    for (const std::string file : {"designs.csv", "designs.npy", "columns.csv", "chosen"}) {
      const Result stopped = scratch.run(
          "rm -rf out; mtf sweep study.toml -o out --accuracy & pid=$!\n"
          "for i in $(seq 3000); do [ -e out/.mtf-new/new/" +
          file + " ] && break; sleep 0.01; done\nkill -" + signal + " $pid; wait $pid");
      EXPECT_EQ(stopped.status, signal == "INT" ? 130 : 137);
      ASSERT_TRUE(fs::exists(scratch / "out/parts/key")) << "it was faster than the signal";
      if (signal == "KILL") fs::copy(scratch / "out/parts", scratch / (file + "-parts"));
      const Result again = scratch.run("mtf sweep study.toml -o out");
      ASSERT_EQ(again.status, 0) << again.err;
      expect_says(again.err, {"which is continued"});
      expect_whole("out");
    }
  // Killed once sweep.json was written, before the key was removed.
  fs::rename(scratch / "chosen-parts", scratch / "out/parts");
  EXPECT_EQ(scratch.run("mtf sweep study.toml -o out").status, 0);
  expect_whole("out");
  // Killed after the key was removed: finished, as any other folder of results.
  fs::rename(scratch / "columns.csv-parts", scratch / "out/parts");
  fs::remove(scratch / "out/parts/key");
  const Result finished = scratch.run("mtf sweep study.toml -o out");
  EXPECT_EQ(finished.status, 2);
  expect_says(finished.err, {"out is not empty"});
  EXPECT_EQ(scratch.run("mtf report out -o out.html").status, 0);
  EXPECT_EQ(scratch.run("mtf sweep study.toml -o out --force").status, 0);
  expect_whole("out");
  // Killed before the key was written.
  fs::create_directories(scratch / "begun/parts");
  write_file(scratch / "begun/parts/key.tmp.4194305", "left");  // above the largest id of a process (2^22)
  EXPECT_EQ(scratch.run("mtf sweep study.toml -o begun").status, 0);
  expect_whole("begun");
}

TEST(SweepCommand, AStoppedRunOfAnotherStudyIsNotGoneOnWith) {
  const Scratch scratch;
  add_study(scratch, sampled_study(4096, 20));
  stopped(scratch, "KILL");
  write_file(scratch / "study.toml", sampled_study(100, 2));
  const Result other = scratch.run("mtf sweep study.toml -o out");
  EXPECT_EQ(other.status, 2);
  expect_says(other.err, {"stopped sweep", "another study"});
  EXPECT_TRUE(fs::exists(scratch / "out/parts/rows-0000000000"));
  ASSERT_EQ(scratch.run("mtf sweep study.toml -o out --force").status, 0);
  ASSERT_EQ(scratch.run("mtf sweep study.toml -o new").status, 0);
  EXPECT_EQ(tables(scratch, "out"), tables(scratch, "new"));
}

}  // namespace
}  // namespace apps_test
