// SPDX-License-Identifier: Apache-2.0

// apps/simulate called as a library: the same pixels as the command's files, whatever the scene comes from and wherever
// the images go.

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <mutex>

#include "apps/simulate/live_simulation.h"
#include "apps/simulate/simulate.h"
#include "mtf/engines/statistics.h"
#include "mtf/io/config/schedule.h"
#include "tests/apps/chain_sensor.h"
#include "tests/expect_error.h"
#include "tests/replaced.h"

namespace apps_test {
namespace {

using apps::SceneSource;
using apps::SimulateEvent;
using apps::SimulateOptions;
using apps::SimulateResult;

constexpr std::int64_t kSize = 320, kLargeSize = 1700;  // the latter takes several tiles in kMemory
constexpr std::int64_t kMemory = std::int64_t{105} << 20;

/// Contrast of its own, about `mean`.
Image pattern(double mean, double amplitude, std::int64_t size = kSize) {
  Image plane(size, size);
  for (std::int64_t y = 0; y < size; ++y)
    for (std::int64_t x = 0; x < size; ++x)
      plane.at(x, y) = static_cast<float>(mean + amplitude * (std::sin(0.3 * static_cast<double>(x * x % 97)) *
                                                                  std::cos(0.21 * static_cast<double>(y)) +
                                                              (x > y ? 1.0 : 0.0)));
  return plane;
}

bool same_pixels(const Image& a, const Image& b) {
  return a.width() == b.width() && a.height() == b.height() &&
         std::memcmp(a.data(), b.data(), static_cast<std::size_t>(a.size()) * sizeof(float)) == 0;
}

class SimulateCall : public testing::Test {
 protected:
  void SetUp() override {
    scratch.add_sensor();
    std::string text = read_file(scratch / "sensor.toml");
    text = replaced(text, "format = [640, 512]", "# no format        ");
    write_file(scratch / "sensor.toml", text);
    write_file(scratch / "camera.toml",
               kSensor + "[nonuniformity]\nprnu = 0.02\n[noise]\nseed = 3\n[adc]\nbits = 14\n");
    write_scene("scene.exr", pattern(5.0, 1.0), "radiance");
    write_scene("thermal.exr", pattern(300.0, 3.0), "temperature");
    write_file(scratch / "schedule.csv", "frame,parameter,value\n1,jitter.rms,9 urad\n3,jitter.rms,12 urad\n");
  }
  void write_scene(const std::string& name, const Image& plane, const std::string& quantity) const {
    mtf::io::Metadata metadata;
    metadata.text["mtf:quantity"] = quantity;
    mtf::io::write_exr((scratch / name).string(), {{"Y", plane.view()}}, metadata);
  }
  mtf::io::SensorConfig sensor(const std::string& name = "sensor.toml") const {
    return apps::read_sensor_file((scratch / name).string());
  }
  /// The same as the file, in memory.
  SceneSource radiance() const { return in_memory(pattern(5.0, 1.0), mtf::io::Quantity::radiance); }
  SceneSource temperatures() const { return in_memory(pattern(300.0, 3.0), mtf::io::Quantity::temperature); }
  SceneSource file(const std::string& name) const { return {.file = (scratch / name).string()}; }
  static SceneSource in_memory(Image plane, mtf::io::Quantity quantity) {
    mtf::io::Scene scene;
    scene.quantity = quantity;
    scene.planes.push_back(std::move(plane));
    return {.image = std::move(scene)};
  }
  Image of_command(const std::string& arguments) const {
    const Result r = scratch.run("mtf simulate " + arguments);
    EXPECT_EQ(r.status, 0) << r.err;
    return read(scratch / "out.exr");
  }
  const Scratch scratch;
};

TEST_F(SimulateCall, GivesThePixelsOfTheCommand) {
  const Image expected = of_command("sensor.toml scene.exr -o out.exr --tolerance 1e-3");
  for (const bool memory : {false, true}) {
    const SimulateResult result =
        apps::simulate(sensor(), memory ? radiance() : file("scene.exr"), {.tolerance = 1e-3});
    ASSERT_EQ(result.images.size(), 1U);
    EXPECT_TRUE(same_pixels(result.images[0].planes.at(0), expected)) << memory;
    EXPECT_EQ(result.names, std::vector<std::string>{"Y"});
    EXPECT_EQ(result.report.unit(), "W.m^-2.sr^-1");
    EXPECT_EQ(result.report.tolerance, 1e-3);
    EXPECT_LE(result.report.plan->predicted_error, 1e-3);
    EXPECT_EQ(result.images[0].metadata.text.at("mtf:units"), "W.m^-2.sr^-1");
    EXPECT_EQ(result.statistics.at(0).not_finite, 0);
  }
}

TEST_F(SimulateCall, GivesTheCountsOfTheCommand) {
  const Image expected = of_command("camera.toml thermal.exr -o out.exr");
  const SimulateResult result = apps::simulate(sensor("camera.toml"), temperatures());
  EXPECT_TRUE(same_pixels(result.images.at(0).planes.at(0), expected));
  EXPECT_EQ(result.report.unit(), "counts");
  ASSERT_TRUE(result.report.chain.has_value());
  EXPECT_EQ(Json::parse(to_json(result.report))["units"], "counts");
}

// The counts of a camera that states its constants, emissivity and what is reflected are the temperatures that they
// stand for; the sensor file has the last word.
TEST_F(SimulateCall, AFileSaysWhatItsCountsAre) {
  const radiometry::CountCamera camera{.r1 = 14985.93, .b_k = 1398.1, .f = 1.0, .o = -6233.0, .r2 = 0.0112832};
  SceneSource counts = in_memory(pattern(300.0, 3.0), mtf::io::Quantity::counts);
  Image& plane = counts.image->planes.front();
  for (std::int64_t i = 0; i < plane.size(); ++i)
    plane.data()[i] =
        static_cast<float>(0.9 * camera.count(static_cast<double>(plane.data()[i])) + 0.1 * camera.count(285.0));
  counts.image->info.attributes = {{"camera_counts.R1", "14985.93"},  {"camera_counts.B", "1398.1"},
                                   {"camera_counts.F", "1"},          {"camera_counts.O", "-6233"},
                                   {"camera_counts.R2", "0.0112832"}, {"scene.emissivity", "0.9"},
                                   {"scene.surroundings", "285 K"}};
  const std::string camera_file = read_file(scratch / "camera.toml");
  const auto with = [&](const std::string& scene, const std::string& more) {
    write_file(scratch / "other.toml",
               replaced(camera_file, "quantity = \"temperature\"\n", "quantity = \"temperature\"\n" + scene) + more);
    return sensor("other.toml");
  };
  std::string said;
  SimulateOptions options;
  options.watch = [&](const SimulateEvent& event) {
    if (event.kind == SimulateEvent::Kind::warning) said += event.text;
    return true;
  };
  const auto image = [&](const mtf::io::SensorConfig& config, const SceneSource& source) {
    said.clear();
    return std::move(apps::simulate(config, apps::clone(source), options).images.at(0).planes.at(0));
  };
  const auto difference = [](const Image& a, const Image& b) {
    double most = 0.0;
    for (std::int64_t i = 0; i < a.size(); ++i)
      most = std::max(most, std::abs(static_cast<double>(a.data()[i]) - static_cast<double>(b.data()[i])));
    return most;
  };
  const Image expected = image(with("emissivity = 0.9\nsurroundings = \"285 K\"\n", ""), temperatures());
  EXPECT_LE(difference(image(sensor("camera.toml"), counts), expected), 1.0);  // a float of counts may round otherwise
  expect_says(said, {"constants of the camera in the file", "emissivity 0.9, reflected 285 K"});
  const std::string constants = "[camera_counts]\nR1 = 14985.93\nB = 1398.1\nF = 1.0\nO = -6000\nR2 = 0.0112832\n";
  EXPECT_GT(difference(image(with("", constants), counts), expected), 10.0);
  expect_says(said, {"by [camera_counts] with emissivity 0.9"});
  EXPECT_GT(difference(image(with("emissivity = 0.8\nsurroundings = \"285 K\"\n", ""), counts), expected), 10.0);
  expect_says(said, {"emissivity 0.8, reflected 285 K"});
  auto& attributes = counts.image->info.attributes;
  for (const auto& [key, value] : {std::pair{"flir.window_transmission", "1.5"},
                                   {"scene.emissivity", "nan"},
                                   {"flir.distance", "-3 m"},
                                   {"flir.air_temperature", "290 K"},
                                   {"flir.relative_humidity", "0.5"},
                                   {"flir.alpha1", "0.006569"},
                                   {"flir.alpha2", "0.01262"},
                                   {"flir.beta1", "-0.002276"},
                                   {"flir.beta2", "-0.00667"},
                                   {"flir.X", "1.9"}})
    attributes[key] = value;
  static_cast<void>(image(sensor("camera.toml"), counts));
  expect_says(said, {"transmission of the window 1.5", "emissivity nan", "air, of distance -3 m"});
  attributes["flir.distance"] = "3 m", attributes["flir.relative_humidity"] = "1.5";
  static_cast<void>(image(sensor("camera.toml"), counts));
  expect_says(said, {"humidity 1.5"});
  attributes["camera_counts.F"] = "0";
  expect_refused<mtf::UsageError>({"F = 0", "[camera_counts]"}, [&] { image(sensor("camera.toml"), counts); });
}

TEST_F(SimulateCall, GivesTheFramesOfTheCommandInTheirOrder) {
  ASSERT_EQ(scratch.run("mtf simulate sensor.toml scene.exr -o f.%d.exr --schedule schedule.csv --frames 1:4").status,
            0);
  const SimulateOptions options{.frames = apps::FrameRange{1, 4, 1}, .schedule = (scratch / "schedule.csv").string()};
  const SimulateResult result = apps::simulate(sensor(), radiance(), options);
  ASSERT_EQ(result.images.size(), 4U);
  for (std::int64_t i = 0; i < 4; ++i) {
    const apps::SimulatedImage& image = result.images[static_cast<std::size_t>(i)];
    EXPECT_EQ(image.frame, i + 1);
    EXPECT_TRUE(same_pixels(image.planes.at(0), read(scratch / ("f." + std::to_string(i + 1) + ".exr")))) << i;
  }
  EXPECT_EQ(result.images[2].metadata.text.at("mtf:schedule"), "jitter.rms = 12 urad");
  EXPECT_EQ(result.report.sequence->plans_updated, 1);
}

TEST_F(SimulateCall, ASinkGetsTheTilesOfAnImage) {
  write_scene("large.exr", pattern(5.0, 1.0, kLargeSize), "radiance");
  const Image expected = of_command("sensor.toml large.exr -o out.exr --memory 105MiB");
  Image assembled(expected.width(), expected.height());
  std::mutex lock;
  std::int64_t parts = 0, pixels = 0;
  SimulateOptions options{.memory = kMemory};
  options.sink = [&](const apps::ImagePart& part) {
    const std::scoped_lock guard(lock);
    ++parts;
    pixels += part.region.width * part.region.height;
    for (std::int64_t y = 0; y < part.region.height; ++y)
      for (std::int64_t x = 0; x < part.region.width; ++x)
        assembled.at(part.region.x + x, part.region.y + y) = part.planes[0].at(x, y);
  };
  const SimulateResult result = apps::simulate(sensor(), file("large.exr"), options);
  EXPECT_TRUE(result.images.empty());
  EXPECT_GT(parts, 1);
  EXPECT_EQ(parts, result.report.tiles->plan.count);
  EXPECT_EQ(pixels, expected.size());
  EXPECT_TRUE(same_pixels(assembled, expected));

  options.sink = nullptr;  // and without one they are put together
  EXPECT_TRUE(same_pixels(apps::simulate(sensor(), file("large.exr"), options).images.at(0).planes.at(0), expected));
}

TEST_F(SimulateCall, ARegionOfASceneInMemory) {
  const Image expected = of_command("sensor.toml scene.exr -o out.exr --roi 20,30,25,15");
  const SimulateResult result =
      apps::simulate(sensor(), radiance(), {.region = std::array<std::int64_t, 4>{20, 30, 25, 15}});
  EXPECT_TRUE(same_pixels(result.images.at(0).planes.at(0), expected));
}

// Of a camera the whole image is made, and the region is cut from it.
TEST_F(SimulateCall, ARegionOfACameraHasItsOwnStatistics) {
  const SimulateResult whole = apps::simulate(sensor("camera.toml"), temperatures());
  const SimulateResult part =
      apps::simulate(sensor("camera.toml"), temperatures(), {.region = std::array<std::int64_t, 4>{5, 6, 7, 8}});
  const Image& image = part.images.at(0).planes.at(0);
  EXPECT_EQ(image.at(0, 0), whole.images.at(0).planes.at(0).at(5, 6));
  EXPECT_EQ(part.statistics.at(0).mean, mtf::statistics(image.view()).mean);
  EXPECT_NE(part.statistics.at(0).mean, whole.statistics.at(0).mean);
  EXPECT_EQ(Json::parse(to_json(part.report))["out_size"], Json({7, 8}));
}

TEST_F(SimulateCall, TellsProgressAndEndsWhereTheCallerSaysSo) {
  std::vector<std::string> stages;
  SimulateOptions options{.out = (scratch / "out.exr").string()};
  options.watch = [&](const SimulateEvent& event) {
    if (event.kind == SimulateEvent::Kind::stage) stages.emplace_back(event.text);
    return true;
  };
  EXPECT_TRUE(apps::simulate(sensor(), radiance(), options).images.empty());
  EXPECT_EQ(stages, (std::vector<std::string>{"read", "plan", "run", "write"}));
  fs::remove(scratch / "out.exr");

  options.watch = [](const SimulateEvent& event) { return event.text != "plan"; };
  EXPECT_THROW(apps::simulate(sensor(), radiance(), options), apps::Cancelled);
  EXPECT_FALSE(fs::exists(scratch / "out.exr"));

  double last = -1.0;  // of a sequence, after its first frame; what is written is whole
  options.out = (scratch / "s.%d.exr").string();
  options.frames = apps::FrameRange{1, 9, 1};
  options.schedule = (scratch / "schedule.csv").string();
  options.watch = [&](const SimulateEvent& event) {
    last = event.value;
    return event.kind != SimulateEvent::Kind::share;
  };
  EXPECT_THROW(apps::simulate(sensor(), radiance(), options), apps::Cancelled);
  EXPECT_NEAR(last, 1.0 / 9.0, 1e-12);
  EXPECT_EQ(read(scratch / "s.1.exr").size(), 80 * 80);
}

TEST_F(SimulateCall, WarningsAreTheSameInEventsAndReport) {
  std::vector<std::string> told;
  SimulateOptions options;
  options.watch = [&](const SimulateEvent& event) {
    if (event.kind == SimulateEvent::Kind::warning) told.emplace_back(event.text);
    return true;
  };
  mtf::io::SensorConfig coarse = sensor();
  coarse.system.frame.pitch_x_um = coarse.system.frame.pitch_y_um = 5.0;  // little more than a sample of the scene
  SceneSource scene = radiance();
  scene.image->grid.step_x_um = scene.image->grid.step_y_um = 3.75;
  const SimulateResult result = apps::simulate(coarse, std::move(scene), options);
  EXPECT_FALSE(told.empty());
  EXPECT_EQ(told, result.report.warnings);
}

TEST_F(SimulateCall, PlanesBesideASceneInMemory) {
  std::string text = read_file(scratch / "camera.toml");
  text = replaced(text, "quantity = \"temperature\"",
                  "quantity = \"temperature\"\nemissivity_channel = \"e\"\nsurroundings = \"280 K\"");
  write_file(scratch / "surface.toml", text);
  const Image emissivity = pattern(0.7, 0.1);
  const Image temperature = pattern(300.0, 3.0);
  mtf::io::Metadata metadata;
  metadata.text["mtf:quantity"] = "temperature";
  mtf::io::write_exr((scratch / "both.exr").string(), {{"Y", temperature.view()}, {"e", emissivity.view()}}, metadata);
  const Image expected = of_command("surface.toml both.exr -o out.exr --channel Y");
  SceneSource scene = temperatures();
  scene.beside.emplace("e", pattern(0.7, 0.1));
  EXPECT_TRUE(
      same_pixels(apps::simulate(sensor("surface.toml"), std::move(scene)).images.at(0).planes.at(0), expected));
  EXPECT_THROW(apps::simulate(sensor("surface.toml"), temperatures()), mtf::UsageError);
}

TEST_F(SimulateCall, RefusesScenesThatAreNone) {
  const auto refusal = [&](SceneSource scene, const SimulateOptions& options = {}) -> std::string {
    mtf::io::SensorConfig config = sensor();
    config.scene.sample_x_um = config.scene.sample_y_um = std::nullopt;
    try {
      apps::simulate(config, std::move(scene), options);
    } catch (const mtf::UsageError& error) {
      return error.what();
    }
    return "";
  };
  expect_says(refusal(SceneSource{}), {"no scene"});
  expect_says(refusal(radiance()), {"sample spacing"});
  SceneSource none = radiance(), uneven = radiance(), limited = radiance();
  none.image->planes.clear();
  none.image->grid.step_x_um = none.image->grid.step_y_um = 3.75;
  expect_says(refusal(std::move(none)), {"no planes"});
  uneven.image->planes.push_back(Image(4, 4));
  uneven.image->grid.step_x_um = uneven.image->grid.step_y_um = 3.75;
  expect_says(refusal(std::move(uneven)), {"4x4"});
  limited.file = "made here";
  expect_says(refusal(std::move(limited), {.memory = 1 << 30}), {"in memory"});
  expect_says(refusal(radiance(), {.memory = 1 << 30}), {"--memory", "scene in memory"});
}

TEST_F(SimulateCall, RefusesFramesThatAreNone) {
  constexpr std::int64_t least = std::numeric_limits<std::int64_t>::min();
  constexpr std::int64_t most = std::numeric_limits<std::int64_t>::max();
  for (const apps::FrameRange range :
       {apps::FrameRange{5, 1, 1}, {1, 4, 0}, {1, 4, -1}, {least, most, 1}, {0, most, 1}})
    EXPECT_THROW(apps::simulate(sensor(), radiance(), {.frames = range}), mtf::UsageError)
        << range.first << " " << range.last << " " << range.step;
  write_file(scratch / "empty.csv", "frame,parameter,value\n");
  EXPECT_THROW(apps::simulate(sensor(), radiance(), {.schedule = (scratch / "empty.csv").string()}), mtf::UsageError);
}

TEST_F(SimulateCall, RefusesAnOutputOfUnknownFormatBeforeAnyWork) {
  bool worked = false;
  SimulateOptions options{.out = (scratch / "a.jpg").string()};
  options.watch = [&](const SimulateEvent&) { return worked = true; };
  EXPECT_THROW(apps::simulate(sensor(), radiance(), options), mtf::UsageError);
  EXPECT_FALSE(worked);
}

TEST_F(SimulateCall, ARangeGivesTheScaleOfWholeNumbers) {
  const SimulateResult result = apps::simulate(
      sensor(), radiance(), {.out = (scratch / "out.png").string(), .range = std::array<double, 2>{2.0, 12.0}});
  EXPECT_EQ(result.report.scaling.offset, 2.0);
  EXPECT_DOUBLE_EQ(result.report.scaling.gain, 10.0 / 65535.0);
}

TEST_F(SimulateCall, ALiveViewShowsTheFramesOfTheSequence) {
  ASSERT_EQ(scratch.run("mtf simulate sensor.toml scene.exr -o f.%d.exr --schedule schedule.csv --frames 1:4").status,
            0);
  const mtf::io::SensorConfig config = sensor();
  mtf::io::ScheduledSensor schedule(config, mtf::io::read_schedule((scratch / "schedule.csv").string(), config));
  apps::LiveSimulation live(radiance());
  for (std::int64_t i = 1; i <= 4; ++i) {
    schedule.advance(i);
    const apps::SimulatedImage image = live.image(schedule.sensor(), i);
    EXPECT_TRUE(same_pixels(image.planes.at(0), read(scratch / ("f." + std::to_string(i) + ".exr")))) << i;
  }
  EXPECT_EQ(live.plans_compiled(), 1);
  EXPECT_EQ(live.plans_updated(), 1);
  EXPECT_EQ(live.names(), std::vector<std::string>{"Y"});
  EXPECT_LE(live.plan().predicted_error, live.plan().options.tolerance);
}

TEST_F(SimulateCall, ALiveViewOfACameraKeepsItsNoiseByFrame) {
  apps::LiveSimulation live(temperatures());
  const mtf::io::SensorConfig camera = sensor("camera.toml");
  const Image first = std::move(live.image(camera, 1).planes.at(0));
  EXPECT_FALSE(same_pixels(live.image(camera, 2).planes.at(0), first));
  EXPECT_TRUE(same_pixels(live.image(camera, 1).planes.at(0), first));
  EXPECT_THROW(live.image(camera, -1), mtf::UsageError);
  EXPECT_TRUE(same_pixels(live.image(camera, 1).planes.at(0), first));
}

}  // namespace
}  // namespace apps_test
