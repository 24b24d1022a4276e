// SPDX-License-Identifier: Apache-2.0
// `mtf sweep plan | run | merge | submit`.

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "tests/apps/study/small_study.h"
#include "tests/expect_error.h"

namespace apps_test {
namespace {

using nlohmann::json;
using study_test::add_study;
using study_test::kSmallStudy;

void expect_same_tables(const Scratch& scratch, const std::string& a, const std::string& b) {
  for (const char* name : {"/designs.csv", "/designs.npy"}) {
    EXPECT_NE(read_file(scratch / (a + name)), "");
    EXPECT_EQ(read_file(scratch / (a + name)), read_file(scratch / (b + name)));
  }
}

/// study.toml swept to `local`, and planned in three shards.
void add_plan(const Scratch& scratch) {
  add_study(scratch);
  ASSERT_EQ(scratch.run("mtf sweep study.toml -o local").status, 0);
  ASSERT_EQ(scratch.run("mtf sweep plan study.toml -o plan --shards 3").status, 0);
}

fs::path shard_file(const Scratch& scratch, int shard) {
  for (const auto& entry : fs::directory_iterator(scratch / "plan/shards"))
    if (entry.path().filename().string().starts_with("part-" + std::to_string(shard) + "-")) return entry.path();
  return {};
}

TEST(SweepShards, MergeToTheBytesOfALocalRun) {
  const Scratch scratch;
  add_plan(scratch);
  fs::remove(scratch / "study.toml");  // the plan is complete in itself, wherever it is
  fs::rename(scratch / "plan", scratch / "moved");
  EXPECT_EQ(scratch.run("mtf sweep run moved --shard 3/3 --threads 1").status, 0);
  EXPECT_EQ(scratch.run("SLURM_ARRAY_TASK_ID=1 mtf sweep run moved").status, 0);
  EXPECT_EQ(scratch.run("cd moved && mtf sweep run . --shard 2/3").status, 0);
  const Result merged = scratch.run("mtf sweep merge moved -o merged");
  ASSERT_EQ(merged.status, 0) << merged.err;
  expect_same_tables(scratch, "local", "merged");
  json one = json::parse(read_file(scratch / "local/sweep.json")),
       two = json::parse(read_file(scratch / "merged/sweep.json"));
  for (json* each : {&one, &two}) {
    each->erase("timing");
    each->erase("accuracy");  // holds times
  }
  EXPECT_EQ(one, two);
}

TEST(SweepShards, AShardRunTwiceSaysSoAndDoesNothing) {
  const Scratch scratch;
  add_plan(scratch);
  ASSERT_EQ(scratch.run("mtf sweep run plan --shard 2/3").status, 0);
  const auto before = fs::last_write_time(shard_file(scratch, 2));
  const Result again = scratch.run("mtf sweep run plan --shard 2/3");
  EXPECT_EQ(again.status, 0);
  expect_says(again.out, {"shard 2/3", "(designs 39 to 77)", "nothing to do"});
  EXPECT_EQ(fs::last_write_time(shard_file(scratch, 2)), before);
}

/// A shard that was killed between its last rename and the end, or that two processes made at once.
void leave_parts(const fs::path& shard) {
  fs::create_directory(shard.string() + ".parts");
  write_file(shard.string() + ".parts/rows-0000000000", "left");
  write_file(shard.string() + ".tmp.4194305", "left");  // above the largest id of a process (2^22)
}

TEST(SweepShards, WhatAKilledRunLeftGoesWhenItsShardIsFoundFinished) {
  const Scratch scratch;
  add_plan(scratch);
  ASSERT_EQ(scratch.run("mtf sweep submit plan --engine local --submit").status, 0);
  const std::string before = scratch.run("ls plan/shards").out;
  ASSERT_EQ(lines(before), 3U);
  leave_parts(shard_file(scratch, 2));
  EXPECT_EQ(scratch.run("mtf sweep run plan --shard 2/3").status, 0);
  EXPECT_EQ(scratch.run("ls plan/shards").out, before);
  leave_parts(shard_file(scratch, 1));
  leave_parts(shard_file(scratch, 3));
  EXPECT_EQ(scratch.run("mtf sweep merge plan -o merged").status, 0);
  EXPECT_EQ(scratch.run("ls plan/shards").out, before);
  expect_same_tables(scratch, "local", "merged");
}

TEST(SweepShards, TwoRunsOfOneShardLeaveTheShardAlone) {
  const Scratch scratch;
  add_plan(scratch);
  const Result result = scratch.run(
      "for i in 1 2 3 4; do mtf sweep run plan --shard 2/3 --threads 1 & pids=\"$pids $!\"; done\n"
      "for pid in $pids; do wait $pid || exit 1; done; ls plan/shards");
  EXPECT_EQ(result.status, 0) << result.err;
  EXPECT_EQ(lines(result.out.substr(result.out.find("part-"))), 1U) << result.out;
}

TEST(SweepShards, ADamagedShardIsMadeAgain) {
  const Scratch scratch;
  add_plan(scratch);
  ASSERT_EQ(scratch.run("mtf sweep submit plan --engine local --submit").status, 0);
  const fs::path file = shard_file(scratch, 2);
  const std::string good = read_file(file);
  write_file(file, good.substr(0, good.size() - 5));
  const Result merge = scratch.run("mtf sweep merge plan -o merged");
  expect_error(merge, 1, {"shard 2: "});
  expect_says(merge.err, {": damaged:", "ends too early"});
  EXPECT_FALSE(fs::exists(scratch / "merged"));
  const Result run = scratch.run("mtf sweep run plan --shard 2/3");
  EXPECT_EQ(run.status, 0);
  expect_says(run.err, {"making it again"});
  EXPECT_EQ(read_file(file), good);
  EXPECT_EQ(scratch.run("mtf sweep merge plan -o merged").status, 0);
  expect_same_tables(scratch, "local", "merged");
}

// A bit that flipped in the key would make the shard look like one of another study.
TEST(SweepShards, AFlippedBitOfAShardIsDamageWithTheCommandThatMendsIt) {
  const Scratch scratch;
  add_plan(scratch);
  ASSERT_EQ(scratch.run("mtf sweep submit plan --engine local --submit").status, 0);
  const fs::path file = shard_file(scratch, 2);
  const std::string good = read_file(file);
  const std::size_t number = good.size() - 100;  // of a row
  for (const std::size_t at : {good.find("key ") + 4, good.find("first ") + 6, number}) {
    std::string bad = good;
    bad[at] = static_cast<char>(bad[at] ^ 1);
    write_file(file, bad);
    const Result merge = scratch.run("mtf sweep merge plan -o merged");
    expect_error(merge, 1, {file.filename().string() + ": damaged: "});
    if (at == number) expect_says(merge.err, {"the row of design"});
    expect_says(merge.err, {"computed again", "run plan --shard 2/3`\n"});
    EXPECT_FALSE(fs::exists(scratch / "merged"));
    EXPECT_EQ(scratch.run("mtf sweep run plan --shard 2/3").status, 0);
    EXPECT_EQ(read_file(file), good);
  }
}

TEST(SweepShards, AStoppedMergeGoesOn) {
  const Scratch scratch;
  add_plan(scratch);
  ASSERT_EQ(scratch.run("mtf sweep submit plan --engine local --submit").status, 0);
  const Result stopped = scratch.run(
      "mtf sweep merge plan -o merged --accuracy & pid=$!\n"
      "for i in $(seq 3000); do [ -e merged/.mtf-new/new/designs.csv ] && break; sleep 0.01; done\n"
      "kill -KILL $pid; wait $pid");
  EXPECT_EQ(stopped.status, 137);
  ASSERT_TRUE(fs::exists(scratch / "merged/parts/key")) << "it was faster than the signal";
  const Result again = scratch.run("mtf sweep merge plan -o merged");
  EXPECT_EQ(again.status, 0) << again.err;
  expect_says(again.err, {"which is continued"});
  expect_same_tables(scratch, "local", "merged");
  EXPECT_FALSE(fs::exists(scratch / "merged/parts"));
}

TEST(SweepShards, MissingAndForeignShardsAreNamed) {
  const Scratch scratch;
  add_plan(scratch);
  ASSERT_EQ(scratch.run("mtf sweep run plan --shard 2/3").status, 0);
  expect_error(scratch.run("mtf sweep merge plan -o merged"), 1, {"shards 1 and 3", "missing"});
  ASSERT_EQ(scratch.run("mtf sweep submit plan --engine local --submit").status, 0);
  // A shard of the same study at another tolerance, under the name of this one.
  ASSERT_EQ(scratch
                .run("mtf sweep plan study.toml -o other --shards 3 --tolerance 1e-3\n"
                     "mtf sweep run other --shard 1/3\n"
                     "cp other/shards/part-1-* plan/shards/\n")
                .status,
            0);
  const Result foreign = scratch.run("mtf sweep merge plan -o merged");
  expect_error(foreign, 1, {": foreign"});
  ASSERT_EQ(scratch
                .run("cd plan/shards; rm $(cd ../../other/shards; ls)\n"
                     "cp ../../other/shards/part-1-* $(ls part-1-*)\n")
                .status,
            0);
  const std::string bytes = read_file(shard_file(scratch, 1));
  for (const char* command : {"mtf sweep merge plan -o merged", "mtf sweep run plan --shard 1/3"}) {
    expect_error(scratch.run(command), 1, {": foreign:", "another study"});
  }
  EXPECT_EQ(read_file(shard_file(scratch, 1)), bytes);
}

TEST(SweepShards, AStudyThatChangesBetweenShardsIsRefused) {
  const Scratch scratch;
  add_plan(scratch);
  ASSERT_EQ(scratch.run("mtf sweep run plan --shard 1/3").status, 0);
  for (const char* name : {"plan/study.toml", "plan/sensor.toml"}) {
    const std::string text = read_file(scratch / name);
    write_file(scratch / name, text + "\n# another\n");
    for (const char* command : {"mtf sweep run plan --shard 2/3", "mtf sweep merge plan -o merged",
                                "mtf sweep submit plan --engine local --submit"}) {
      expect_error(scratch.run(command), 2, {std::string(name) + ": changed since"});
    }
    write_file(scratch / name, text);
  }
  EXPECT_EQ(scratch.run("mtf sweep run plan --shard 2/3").status, 0);
}

TEST(SweepShards, APlanWithFinishedShardsIsNotReplaced) {
  const Scratch scratch;
  add_plan(scratch);
  EXPECT_EQ(scratch.run("mtf sweep plan study.toml -o plan --shards 2").status, 2);
  EXPECT_EQ(scratch.run("mtf sweep plan study.toml -o plan --shards 2 --force").status, 0);
  ASSERT_EQ(scratch.run("mtf sweep run plan --shard 1/2").status, 0);
  expect_error(scratch.run("mtf sweep plan study.toml -o plan --shards 4 --force"), 2, {"holds 1 finished shards"});
  EXPECT_FALSE(shard_file(scratch, 1).empty());
}

TEST(SweepShards, AnotherShareOfThePlanIsRefused) {
  const Scratch scratch;
  add_plan(scratch);
  const std::vector<std::pair<std::string, std::string>> cases{
      {"mtf sweep run plan --shard 1/4", "3 shards, not 4"},
      {"mtf sweep run plan", "SLURM_ARRAY_TASK_ID"},
      {"SLURM_ARRAY_TASK_ID=4 mtf sweep run plan", "from 1 to 3"},
      {"SLURM_ARRAY_TASK_ID=x mtf sweep run plan", "from 1 to 3"}};
  for (const auto& [command, message] : cases) {
    expect_error(scratch.run("unset SLURM_ARRAY_TASK_ID\n" + command), 2, {message});
  }
}

// The same name goes through GNU parallel in tests/slurm/parallel.sh, which needs that program.
TEST(SweepShards, AnyNameOfAPlanGoesThroughTheLocalEngine) {
  const Scratch scratch;
  add_study(scratch);
  write_file(scratch / "name", R"(it's {} a {.} {#} {= $_ =} "$HOME" `plan`)");
  const Result result = scratch.run(
      "plan=$(cat name); mtf sweep plan study.toml -o \"$plan\" --shards 3 &&\n"
      "mtf sweep submit \"$plan\" --engine local --submit && ls \"$plan/shards\"");
  EXPECT_EQ(result.status, 0) << result.err;
  expect_says(result.out, {"part-1-", "part-2-", "part-3-"});
}

TEST(SweepShards, SubmitShowsTheScriptAndRunsItOnlyWhenAsked) {
  const Scratch scratch;
  add_plan(scratch);
  for (const std::string engine : {"slurm", "parallel", "local"}) {
    const Result result = scratch.run("mtf sweep submit plan --engine " + engine);
    EXPECT_EQ(result.status, 0) << result.err;
    EXPECT_EQ(result.out, read_file(scratch / ("plan/submit." + engine + ".sh")));
    expect_says(result.err, {"--submit runs it"});
  }
  EXPECT_TRUE(shard_file(scratch, 1).empty());
  EXPECT_EQ(scratch.run("mtf sweep submit plan --engine local --submit").status, 0);
  EXPECT_EQ(scratch.run("mtf sweep merge plan -o merged").status, 0);
  expect_same_tables(scratch, "local", "merged");
  // Where the engine is not installed that is said.
  fs::create_directory(scratch / "bin");
  expect_error(scratch.run("m=$(command -v mtf); s=$(command -v sh); ln -s $s bin/sh\n"
                           "PATH=$PWD/bin $m sweep submit plan --engine slurm --submit"),
               1, {"sbatch:", "PATH"});
}

}  // namespace
}  // namespace apps_test
