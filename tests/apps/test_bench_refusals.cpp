// SPDX-License-Identifier: Apache-2.0
// Bad input of `mtf bench`, and scenes with nothing in them.
#include <algorithm>
#include <limits>

#include "tests/apps/bench_csv.h"
#include "tests/expect_error.h"

namespace apps_test {
namespace {

TEST(BenchRefusals, OneLineAndNothingWritten) {
  const Scratch scratch;
  scratch.add_sensor();
  write_bench_scene(scratch / "scene.exr", 24, 20);
  mtf::Image bad(8, 8);
  for (std::int64_t i = 0; i < bad.size(); ++i) bad.data()[i] = static_cast<float>(i);
  bad.at(3, 5) = std::numeric_limits<float>::quiet_NaN();
  mtf::io::write_exr((scratch / "nan.exr").string(), {{"Y", bad.view()}}, {});
  write_bench_scene(scratch / "tiny.exr", 2, 2);
  write_file(scratch / "file", "mine");
  struct Case {
    const char* arguments;
    int status;
    const char* word;
  };
  for (const Case& c : {Case{"sensor.toml scene.exr", 2, "--out"},
                        {"sensor.toml missing.exr -o b", 1, "missing.exr"},
                        {"missing.toml scene.exr -o b", 1, "missing.toml"},
                        {"sensor.toml nan.exr -o b", 1, "column 3, row 5"},
                        {"sensor.toml tiny.exr -o b", 2, "one detector pixel"},
                        {"sensor.toml scene.exr -o no/such/b", 1, "no folder"},
                        {"sensor.toml scene.exr -o file", 2, "not a folder"},
                        {"sensor.toml scene.exr -o .", 2, "--force"},
                        {"sensor.toml scene.exr -o b --rounds 0", 2, "--rounds"},
                        {"sensor.toml scene.exr -o b --seconds nan", 2, "--seconds"},
                        {"sensor.toml scene.exr -o b --seconds 0", 2, "--seconds"},
                        {"sensor.toml scene.exr -o b --rigor fast", 2, "--rigor"},
                        {"sensor.toml scene.exr -o b --channel Z", 2, "Z"}}) {
    const Result result = scratch.run(std::string("mtf bench ") + c.arguments);
    EXPECT_EQ(result.status, c.status) << c.arguments << "\n" << result.err;
    EXPECT_TRUE(says(result.err, c.word)) << c.arguments << "\n" << result.err;
    EXPECT_FALSE(fs::exists(scratch / "b")) << c.arguments;
    EXPECT_EQ(result.out, "");
  }
  EXPECT_EQ(read_file(scratch / "file"), "mine");
}

TEST(BenchRefusals, AFlatSceneIsExactWithEveryMethod) {
  const Scratch scratch;
  scratch.add_sensor();
  mtf::Image flat(16, 12);
  for (const float level : {0.0F, 273.15F}) {
    std::fill_n(flat.data(), flat.size(), level);
    mtf::io::write_exr((scratch / "flat.exr").string(), {{"Y", flat.view()}}, {});
    const Result result = scratch.run("mtf bench sensor.toml flat.exr -o b --force --format csv" + kQuick);
    ASSERT_EQ(result.status, 0) << result.err;
    expect_says(result.err, {"the scene is uniform"});
    for (const Row& row : read_rows(result.out))
      EXPECT_EQ(row.at("rms_error"), row.at("method") == "refused" ? "" : "0");
  }
}

TEST(BenchRefusals, OneDetectorPixel) {
  const Scratch scratch;
  scratch.add_sensor();
  write_bench_scene(scratch / "scene.exr", 4, 4);
  const Result result = scratch.run("mtf bench sensor.toml scene.exr -o b --format csv" + kQuick);
  ASSERT_EQ(result.status, 0) << result.err;
  for (const Row& row : read_rows(result.out))
    EXPECT_TRUE(row.at("promised").empty() || value(row, "rms_error") <= value(row, "promised"));
}

TEST(BenchRefusals, SeveralChannelsUseTheFirstAndSaySo) {
  const Scratch scratch;
  scratch.add_sensor();
  mtf::Image a(24, 24), b(24, 24);
  for (std::int64_t i = 0; i < a.size(); ++i) a.data()[i] = static_cast<float>(i % 7), b.data()[i] = 1.0F;
  mtf::io::write_exr((scratch / "rgb.exr").string(), {{"R", a.view()}, {"G", b.view()}, {"B", b.view()}}, {});
  const Result first = scratch.run("mtf bench sensor.toml rgb.exr -o b" + kQuick);
  EXPECT_EQ(first.status, 0) << first.err;
  expect_says(first.err, {"3 channels", "R is used"});
  const Result green = scratch.run("mtf bench sensor.toml rgb.exr --channel G -o c" + kQuick);
  EXPECT_EQ(green.status, 0) << green.err;
  expect_says(green.err, {"the scene is uniform"});
}

TEST(BenchRefusals, InterruptedItLeavesNothing) {
  const Scratch scratch;
  scratch.add_sensor();
  write_bench_scene(scratch / "scene.exr", 256, 256);
  const Result result = scratch.run(
      "mtf bench sensor.toml scene.exr -o b --rounds 10000 --seconds 1000 2>/dev/null >/dev/null & p=$!\n"
      "sleep 0.5; kill -TERM $p; wait $p; echo $?; ls");
  EXPECT_EQ(result.out, "130\nscene.exr\nsensor.toml\n") << result.err;
}

}  // namespace
}  // namespace apps_test
