// SPDX-License-Identifier: Apache-2.0
// Shards of a sweep: made on their own, merged to the same bytes, and every way in which they can be wrong.

#include <gtest/gtest.h>

#include <cmath>

#include "apps/study/rows/row_file.h"
#include "apps/study/rows/row_table.h"
#include "apps/study/rows/shard_plan.h"
#include "mtf/error.h"
#include "mtf/io/sha256.h"
#include "tests/apps/study/temp_folder.h"
#include "tests/expect_error.h"
#include "tests/replaced.h"

namespace {

namespace fs = std::filesystem;
using study_test::read_file;
using study_test::TempFolder;
using study_test::write_file;

constexpr std::int64_t kDesigns = 103;

void fill(std::int64_t design, std::span<double> row) {
  row[0] = static_cast<double>(design);
  row[1] = std::sqrt(row[0]);
}

study::ShardPlan plan_in(const TempFolder& folder, int shards, char key = 'a') {
  write_file(folder / "study.toml", "name = 'x'\n");
  study::ShardPlan plan{.version = "1",
                        .commit = "c",
                        .name = "x",
                        .study_sha256 = std::string(64, '1'),
                        .tolerance = 1e-4,
                        .designs = kDesigns,
                        .shards = shards,
                        .layout = {std::string(64, key), 2},
                        .files = {{"study.toml", mtf::io::sha256_file((folder / "study.toml").string())}}};
  study::write_plan(plan, folder.root());
  return plan;
}

void make_shard(const study::ShardPlan& plan, const TempFolder& folder, int shard, const std::string& name = {}) {
  const study::RowRun run{.layout = plan.layout,
                          .range = study::shard_range(plan, shard),
                          .folder = folder / "rows",
                          .piece = 10,
                          .make = [] { return study::RowMaker(fill); },
                          .done = {}};
  study::run_rows(run);
  study::join_rows(study::rows_of(run),
                   name.empty() ? study::shard_file(plan, folder.root(), shard) : folder.root() / "shards" / name);
  fs::remove_all(folder / "rows");
}

std::string csv_of(const TempFolder& folder, const std::vector<study::RowPiece>& pieces) {
  study::write_table({.pieces = pieces, .columns = {{"a"}, {"b"}}, .csv = folder / "t.csv", .npy = folder / "t.npy"});
  return read_file(folder / "t.csv") + read_file(folder / "t.npy");
}

std::string merge_message(const study::ShardPlan& plan, const TempFolder& folder) {
  return message_of<mtf::RuntimeError>([&] { csv_of(folder, study::all_shards(plan, folder.root())); });
}

TEST(Shards, RangesCoverTheDesignsEvenly) {
  for (const int shards : {1, 2, 7, 103}) {
    study::ShardPlan plan;
    plan.designs = kDesigns;
    plan.shards = shards;
    std::int64_t next = 0;
    for (int shard = 1; shard <= shards; ++shard) {
      const study::RowRange range = study::shard_range(plan, shard);
      EXPECT_EQ(range.first, next);
      EXPECT_GE(range.count, kDesigns / shards);
      EXPECT_LE(range.count, kDesigns / shards + 1);
      next = range.end();
    }
    EXPECT_EQ(next, kDesigns);
  }
}

TEST(Shards, MergedTheyAreTheSameForAnyNumberOfThem) {
  std::string expected;
  for (const int shards : {1, 2, 5, 103}) {
    const TempFolder folder;
    const study::ShardPlan plan = plan_in(folder, shards);
    for (int shard = shards; shard >= 1; --shard) make_shard(plan, folder, shard);
    const std::string merged = csv_of(folder, study::all_shards(plan, folder.root()));
    if (expected.empty()) expected = merged;
    EXPECT_EQ(merged, expected) << shards;
    EXPECT_FALSE(study::find_shard(plan, folder.root(), 1).empty());
  }
}

TEST(Shards, ThePlanReadsBackAsItWasWritten) {
  const TempFolder folder;
  const study::ShardPlan plan = plan_in(folder, 5);
  EXPECT_EQ(study::read_plan(folder.root()), plan);
}

TEST(Shards, AMissingShardIsNamedWithItsCommand) {
  const TempFolder folder;
  const study::ShardPlan plan = plan_in(folder, 5);
  for (const int shard : {1, 3, 4}) make_shard(plan, folder, shard);
  const std::string message = merge_message(plan, folder);
  expect_says(message, {"shards 2 and 5", "missing", "--shard 2/5"});
  EXPECT_TRUE(study::find_shard(plan, folder.root(), 2).empty());
}

TEST(Shards, ADamagedShardIsNamed) {
  const TempFolder folder;
  const study::ShardPlan plan = plan_in(folder, 2);
  make_shard(plan, folder, 1);
  make_shard(plan, folder, 2);
  const fs::path file = study::shard_file(plan, folder.root(), 2);
  const std::string good = read_file(file);
  for (const bool cut : {false, true}) {
    std::string bad = cut ? good.substr(0, good.size() / 2) : good;
    if (!cut) bad[bad.size() - 1] = static_cast<char>(bad.back() ^ 1);
    write_file(file, bad);
    const std::string message = merge_message(plan, folder);
    expect_says(message, {file.filename().string() + ": damaged"});
    EXPECT_THROW(study::find_shard(plan, folder.root(), 2), mtf::RuntimeError);
    EXPECT_EQ(read_file(file), bad);  // nothing is thrown away
  }
}

TEST(Shards, AForeignShardIsNamed) {
  const TempFolder folder;
  const study::ShardPlan plan = plan_in(folder, 2);
  study::ShardPlan other = plan;
  other.layout.key = std::string(64, 'b');
  make_shard(plan, folder, 1);
  const std::string name = study::shard_file(plan, folder.root(), 2).filename().string();
  make_shard(other, folder, 2, name);
  expect_says(merge_message(plan, folder), {"shard 2: " + (folder.root() / "shards" / name).string() + ": foreign"});
  make_shard(plan, folder, 1, name);  // of this plan, but not this shard
  expect_says(merge_message(plan, folder), {"shard 2: "});
  make_shard(plan, folder, 2);
  EXPECT_EQ(merge_message(plan, folder), "");
  make_shard(other, folder, 2, "part-2-0123456789ab");
  expect_says(merge_message(plan, folder), {"part-2-0123456789ab: foreign"});
}

TEST(Shards, AChangedCopyIsRefused) {
  const TempFolder folder;
  plan_in(folder, 2);
  write_file(folder / "study.toml", "name = 'y'\n");
  expect_refused({"study.toml: changed since"}, [&] { study::read_plan(folder.root()); });
}

TEST(Shards, WhatIsNoPlanIsRefused) {
  const TempFolder folder;
  EXPECT_THROW(study::read_plan(folder.root()), mtf::UsageError);
  plan_in(folder, 2);
  const std::string good = read_file(folder / "plan.json");
  for (const std::string& bad : {std::string(), std::string("{}"), std::string("[1"), good.substr(0, good.size() / 2),
                                 std::string("{\"schema\": 2}")}) {
    write_file(folder / "plan.json", bad);
    EXPECT_THROW(study::read_plan(folder.root()), mtf::UsageError) << bad;
  }
  std::string many = good;
  many = replaced(many, "\"shards\": 2", "\"shards\": 0");
  write_file(folder / "plan.json", many);
  EXPECT_THROW(study::read_plan(folder.root()), mtf::UsageError);
}

TEST(Scripts, HoldTheShardsAndQuoteTheirPaths) {
  const study::SubmitJob job{.engine = study::Engine::slurm,
                             .command = "/opt/my tools/mtf",
                             .plan = "/data/it's here",
                             .name = "aperture; rm -rf /",
                             .shards = 12,
                             .threads = 2};
  const std::string slurm = study::submit_script(job);
  expect_says(slurm, {"#SBATCH --array=1-12\n", "#SBATCH --job-name=mtf-aperture-rm-rf\n",
                      "'/opt/my tools/mtf' sweep run '/data/it'\\''s here'"});
  study::SubmitJob other = job;
  other.engine = study::Engine::parallel;
  expect_says(study::submit_script(other), {"--shard {}/12", "--resume-failed"});
  // GNU parallel replaces {} and the like in its command: no path may stand in it.
  other.plan = "/data/{} of {#}";
  other.command = "/opt/{.}/mtf";
  const std::string parallel = study::submit_script(other);
  expect_says(parallel, {"\nPLAN='/data/{} of {#}'\n", "\nMTF='/opt/{.}/mtf'\n"});
  const std::string call = parallel.substr(parallel.find("exec "));
  EXPECT_EQ(call.find('{'), call.find("{}/12")) << call;
  EXPECT_EQ(call.find('{'), call.rfind('{')) << call;
  other.engine = study::Engine::local;
  expect_says(study::submit_script(other), {"seq 1 12"});
}

}  // namespace
