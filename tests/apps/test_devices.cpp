// SPDX-License-Identifier: Apache-2.0
// `mtf devices` and --device, on PoCL where it is there.

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>

#include "apps/simulate/simulate.h"
#include "mtf/device/device_parts.h"
#include "tests/apps/bench_csv.h"
#include "tests/apps/chain_sensor.h"
#include "tests/mtf/device_support.h"

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

// Frames of a sequence on a device that the plan takes, since it is told that work there costs nothing: a batch has the
// bytes that its frames have one by one, and those of 8 bits are the levels of the floats, rounded.
TEST(Devices, MakeTheFilesOfASequenceInBatches) {
  const auto device = mtf::test::open_tested_device();
  if (!device) GTEST_SKIP() << "no device";
  mtf::Device::Parts& parts = device->parts();
  const mtf::DeviceTest measured = std::exchange(parts.test, {.rms = parts.test.rms, .rounding = parts.test.rounding});
  const Scratch scratch;
  write_file(scratch / "camera.toml",
             kSensor +
                 "[nonuniformity]\nprnu = 0.02\ndsnu = \"300 e-\"\n[noise]\nseed = 3\nrow = \"40 e-\"\n"
                 "[adc]\nbits = 14\n[correction]\nframes = 4\n[agc]\nmethod = \"plateau\"\n");
  mtf::Image scene(320, 240);
  for (std::int64_t i = 0; i < scene.size(); ++i)
    scene.data()[i] = 300.0F + 3.0F * std::sin(0.37F * static_cast<float>(i % 320)) + (i % 320 > 200 ? 4.0F : 0.0F);
  mtf::io::Metadata metadata;
  metadata.text["mtf:quantity"] = "temperature";
  mtf::io::write_exr((scratch / "scene.exr").string(), {{"Y", scene.view()}}, metadata);
  const mtf::io::SensorConfig sensor = apps::read_sensor_file((scratch / "camera.toml").string());
  const auto run = [&](const std::string& out, apps::FrameRange frames, radiometry::OutputStage stage) {
    apps::SimulateOptions options;
    options.out = (scratch / out).string();
    options.frames = frames;
    options.stage = stage;
    options.device = {device, true};
    options.threads = 2;
    const auto result = apps::simulate(sensor, {.file = (scratch / "scene.exr").string()}, options);
    EXPECT_EQ(result.report.plan->presample.report().method, "fft_device");
    return result.report.sequence->in_flight;
  };
  using enum radiometry::OutputStage;
  for (const auto stage : {display, dn}) {
    EXPECT_GE(run("all.%02d.png", {1, 21, 2}, stage), 11) << "frames go together";
    run("all.%02d.exr", {1, 21, 2}, stage);
    for (const int number : {1, 5, 21}) {
      run("one.%02d.png", {number, number}, stage);
      const std::string name = (number < 10 ? ".0" : ".") + std::to_string(number);
      const mtf::Image all = read(scratch / ("all" + name + ".png")), one = read(scratch / ("one" + name + ".png")),
                       exact = read(scratch / ("all" + name + ".exr"));
      ASSERT_EQ(all.size(), 160 * 120);
      double most = 0.0;
      for (std::int64_t i = 0; i < all.size(); ++i) {
        ASSERT_EQ(all.data()[i], one.data()[i]) << number;
        ASSERT_EQ(all.data()[i], std::round(exact.data()[i])) << number;
        most = std::max(most, static_cast<double>(std::abs(exact.data()[i] - all.data()[i])));
      }
      EXPECT_EQ(most > 0.2, stage == display) << "the floats of a display are not whole";
    }
  }
  parts.test = measured;
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
