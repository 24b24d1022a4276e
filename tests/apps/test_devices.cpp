// SPDX-License-Identifier: Apache-2.0
// `mtf devices` and --device, on PoCL where it is there.

#include <algorithm>
#include <nlohmann/json.hpp>

#include "tests/apps/bench_csv.h"

namespace apps_test {
namespace {

/// The devices of `mtf devices --format json`.
nlohmann::json listed(const Scratch& scratch) {
  const Result result = scratch.run("mtf devices --format json");
  EXPECT_EQ(result.status, 0) << result.err;
  return nlohmann::json::parse(result.out);
}

TEST(Devices, AreListedTestedAndTimed) {
  const Scratch scratch;
  const nlohmann::json json = listed(scratch);
  if (json["devices"].empty()) GTEST_SKIP() << "no device";
  const Result table = scratch.run("mtf devices");
  ASSERT_EQ(table.status, 0) << table.err;
  for (const auto& device : json["devices"]) {
    EXPECT_GT(device["memory_bytes"].get<double>(), 1e6);
    expect_says(table.out, {device["id"].get<std::string>(), device["name"].get<std::string>()});
    ASSERT_TRUE(device["admitted"].get<bool>()) << device["reason"];
    EXPECT_GT(device["filter_ms"].get<double>(), 0.0);
    for (const auto& rms : device["rms_error"]) EXPECT_LE(rms.get<double>(), 3e-7);
  }
}

TEST(Devices, WithoutDriverOrModuleTheReasonIsSaid) {
  const Scratch scratch;
  if (!listed(scratch)["devices"].empty()) {
    fs::create_directory(scratch / "none");
    for (const char* broken : {"", "libnothing.so.1\n"}) {
      if (*broken != '\0') write_file(scratch / "none/broken.icd", broken);
      const Result result = scratch.run("OCL_ICD_VENDORS=\"$PWD/none\" mtf devices");
      EXPECT_EQ(result.status, 0) << result.err;
      expect_says(result.out, {"opencl: no driver", "OCL_ICD_VENDORS"});
    }
  }
  const Result result = scratch.run("MTFKIT_OPENCL=/none MTFKIT_CUDA=/none mtf devices");
  EXPECT_EQ(result.status, 0) << result.err;
  expect_says(result.out, {"no devices", "opencl: not part", "cuda: not part"});
}

TEST(Devices, AreTakenByTheirIdAndRefusedByName) {
  const Scratch scratch;
  write_bench_scene(scratch / "scene.exr", 60, 48);
  write_bench_sensor(scratch / "sensor.toml", 2, "periodic", kDiffraction);
  expect_error(scratch.run("mtf simulate sensor.toml scene.exr -o out.exr --device voodoo"), 2,
               {"there is no device voodoo"});
  const Result on_its_own =
      scratch.run("MTFKIT_OPENCL=/none MTFKIT_CUDA=/none mtf simulate sensor.toml scene.exr -o out.exr --device auto");
  EXPECT_EQ(on_its_own.status, 0) << on_its_own.err;
  expect_says(on_its_own.err, {"no device beside the processor"});
  const nlohmann::json devices = listed(scratch)["devices"];
  if (devices.empty()) GTEST_SKIP() << "no device";
  const std::string id = devices[0]["id"], option = " --device " + id;
  const Result result = scratch.run("mtf simulate sensor.toml scene.exr -o out.exr --explain" + option);
  ASSERT_EQ(result.status, 0) << result.err;
  expect_says(result.out, {"fft_device", "on " + devices[0]["name"].get<std::string>()});
  const Result bench = scratch.run("mtf bench sensor.toml scene.exr -o b --force" + kQuick + option);
  ASSERT_EQ(bench.status, 0) << bench.err;
  int rows = 0, diamonds = 0;
  for (const Row& row : read_rows(read_file(scratch / "b/bench.csv"))) {
    if (!row.at("method").ends_with("_device")) continue;
    ++(row.at("method") == "fft_device" ? rows : diamonds);
    EXPECT_LE(value(row, "rms_error"), value(row, "promised"));
    EXPECT_LE(value(row, "promised"), value(row, "tolerance"));
  }
  EXPECT_GE(rows, 3);
  EXPECT_GE(diamonds, 1);
}

// The extremes of `mtf check` on the device: every promise is held, and none for want of a comparison.
TEST(Devices, KeepThePromisesOfTheEngineAtItsExtremes) {
  const Scratch scratch;
  const nlohmann::json devices = listed(scratch)["devices"];
  if (devices.empty()) GTEST_SKIP() << "no device";
  const std::string id = devices[0]["id"];
  const Result result = scratch.run("mtf check --format json --device " + id);
  ASSERT_EQ(result.status, 0) << result.out << result.err;
  const nlohmann::json json = nlohmann::json::parse(result.out);
  EXPECT_EQ(json["checks"].size(), 7U);
  for (const auto& check : json["checks"]) EXPECT_EQ(check["component"], "engine, " + id);
}

}  // namespace
}  // namespace apps_test
