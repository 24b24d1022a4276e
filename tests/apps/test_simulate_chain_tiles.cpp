// SPDX-License-Identifier: Apache-2.0

// The chain of a sensor with [detector] in tiles (SimulateOptions::memory) against the whole image.

#include <gtest/gtest.h>

#include <array>
#include <atomic>
#include <cmath>
#include <mutex>

#include "apps/simulate/simulate.h"
#include "apps/simulate/tiles/simulate_tiles.h"
#include "tests/apps/chain_sensor.h"
#include "tests/expect_error.h"
#include "tests/replaced.h"

namespace apps_test {
namespace {

using apps::SimulateEvent;
using apps::SimulateOptions;
using apps::SimulateResult;

// No whole number of tiles, nor of pitches, along either side.
constexpr std::int64_t kWidth = 1702, kHeight = 1463, kColumns = 425, kRows = 365;
constexpr std::int64_t kMemory = std::int64_t{105} << 20;
constexpr double kTolerance = 1e-4;  // 0.01 counts of the scene, whose standard deviation is a hundred

/// All stages that act on each pixel for itself.
const std::string kPixelwise = R"([vignetting]
cos4 = true
[narcissus]
depth = 0.02
[nonuniformity]
prnu = 0.02
dsnu = "300 e-"
[defects]
dead_fraction = 0.0005
hot_fraction = 0.0005
hot = "50 ke-"
[blinking]
fraction = 0.001
excess = "200 ke-"
[nonlinearity]
a2 = -0.02
[flicker]
white = "500 e-"
corner = 0.01
[noise]
seed = 7
row = "100 e-"
column = "100 e-"
fixed_row = "50 e-"
fixed_column = "50 e-"
[noise_3d]
t = "20 e-"
tv = "30 e-"
vh = "30 e-"
tvh = "40 e-"
[adc]
bits = 14
)";
const std::string kConverter = "[noise]\nseed = 3\n[adc]\nbits = 14\n";

class SimulateChainTiles : public testing::Test {
 protected:
  void SetUp() override { write_scene("scene.exr", 300.0, 0.4, "temperature"); }
  void write_scene(const std::string& name, double mean, double amplitude, const std::string& quantity) const {
    Image plane(kWidth, kHeight);
    for (std::int64_t y = 0; y < kHeight; ++y)
      for (std::int64_t x = 0; x < kWidth; ++x)
        plane.at(x, y) = static_cast<float>(mean + amplitude * (std::sin(0.3 * static_cast<double>(x * x % 97)) *
                                                                    std::cos(0.21 * static_cast<double>(y)) +
                                                                (x > y ? 1.0 : 0.0)));
    mtf::io::Metadata metadata;
    metadata.text["mtf:quantity"] = quantity;
    mtf::io::write_exr((scratch / name).string(), {{"Y", plane.view()}}, metadata);
  }
  /// kSensor on samples of a quarter pitch, with more tables, and with one text in place of another.
  mtf::io::SensorConfig sensor(const std::string& more, const std::string& from = "",
                               const std::string& to = "") const {
    std::string text = kSensor + more;
    text = replaced(text, "7.5 um", "3.75 um");
    if (!from.empty()) text.replace(text.find(from), from.size(), to);
    write_file(scratch / "s.toml", text);
    return apps::read_sensor_file((scratch / "s.toml").string());
  }
  SimulateResult run(const mtf::io::SensorConfig& config, const SimulateOptions& options,
                     const std::string& scene = "scene.exr") const {
    return apps::simulate(config, {.file = (scratch / scene).string()}, options);
  }
  static const Image& image_of(const SimulateResult& result) { return result.images.at(0).planes.at(0); }

  /// Share of the pixels that differ; none by more than a count.
  static double share_of_other_counts(const Image& a, const Image& b) {
    EXPECT_EQ(a.width(), b.width());
    EXPECT_EQ(a.height(), b.height());
    std::int64_t other = 0;
    float most = 0.0F;
    for (std::int64_t i = 0; i < a.size(); ++i) {
      const float difference = std::abs(a.data()[i] - b.data()[i]);
      other += difference != 0.0F ? 1 : 0;
      most = std::max(most, difference);
    }
    EXPECT_LE(most, 1.0F);
    return static_cast<double>(other) / static_cast<double>(a.size());
  }
  static Json chain_of(const SimulateResult& result) { return Json::parse(to_json(result.report))["chain"]; }

  void expect_equal(const mtf::io::SensorConfig& config, const std::string& scene = "scene.exr",
                    double tolerance = kTolerance) const {
    const SimulateResult whole = run(config, {.tolerance = tolerance}, scene);
    const SimulateResult tiled = run(config, {.tolerance = tolerance, .memory = kMemory}, scene);
    ASSERT_TRUE(tiled.report.tiles.has_value());
    EXPECT_GT(tiled.report.tiles->plan.count, 1);
    EXPECT_NE(kRows % tiled.report.tiles->plan.side[1], 0);
    EXPECT_EQ(image_of(tiled).width(), kColumns);
    EXPECT_EQ(image_of(tiled).height(), kRows);
    EXPECT_LT(share_of_other_counts(image_of(whole), image_of(tiled)), 1e-3);
    EXPECT_EQ(tiled.report.unit(), "counts");
    EXPECT_EQ(tiled.images.at(0).metadata.text.at("mtf:noise"), whole.images.at(0).metadata.text.at("mtf:noise"));
    EXPECT_NEAR(tiled.statistics.at(0).mean, whole.statistics.at(0).mean, 1e-3);
  }
  void expect_refused(const mtf::io::SensorConfig& config, const SimulateOptions& options,
                      std::initializer_list<std::string_view> parts, const std::string& scene = "scene.exr") const {
    ::expect_refused(parts, [&] { run(config, options, scene); });
    for (const auto& entry : fs::directory_iterator(scratch / ""))
      EXPECT_NE(entry.path().filename().string().substr(0, 3), "out") << entry.path();
  }
  SimulateOptions tiles_to_file(std::optional<double> tolerance = kTolerance) const {
    return {.tolerance = tolerance, .memory = kMemory, .out = (scratch / "out.exr").string()};
  }
  const Scratch scratch;
};

TEST_F(SimulateChainTiles, HaveTheCountsOfTheWholeImage) {
  expect_equal(sensor(kPixelwise));
  expect_equal(sensor(kConverter));
  expect_equal(sensor(kConverter, "quantity = \"temperature\"",
                      "quantity = \"temperature\"\nborder = \"constant\"\nborder_value = 300.0"),
               "scene.exr", 3e-4);  // the edge of the canvas has contrast of its own
  expect_equal(sensor("[lag]\ntime_constant = \"10 ms\"\n" + kConverter));  // acts on the frames of a sequence only
}

TEST_F(SimulateChainTiles, TakeScenesOfRadiance) {
  write_scene("radiance.exr", 1.0, 0.02, "radiance");
  expect_equal(sensor(kConverter), "radiance.exr");
}

TEST_F(SimulateChainTiles, TakeTheirPartOfMaps) {
  const auto map = [&](const std::string& name, double mean, double step) {
    Image plane(kColumns, kRows);
    for (std::int64_t i = 0; i < plane.size(); ++i)
      plane.data()[i] = static_cast<float>(mean + step * static_cast<double>(i % 53));
    mtf::io::write_exr((scratch / name).string(), {{"Y", plane.view()}}, {});
  };
  map("factors.exr", 0.9, 0.003);
  map("offsets.exr", -2000.0, 90.0);
  expect_equal(sensor("[nonuniformity]\nresponsivity = \"factors.exr\"\noffset = \"offsets.exr\"\n" + kConverter));
}

// A stage before the converter: shot noise makes every pixel follow its mean, so the tolerance shows in most of them.
TEST_F(SimulateChainTiles, AnEarlierStageKeepsTheTolerance) {
  const mtf::io::SensorConfig config = sensor(kConverter + "[agc]\n");
  for (const auto stage : {radiometry::OutputStage::radiance, radiometry::OutputStage::electrons}) {
    const SimulateResult whole = run(config, {.tolerance = kTolerance, .stage = stage});
    const SimulateResult tiled = run(config, {.tolerance = kTolerance, .stage = stage, .memory = kMemory});
    EXPECT_GT(tiled.report.tiles->plan.count, 1);
    double squares = 0.0;
    for (std::int64_t i = 0; i < image_of(whole).size(); ++i)
      squares += std::pow(static_cast<double>(image_of(whole).data()[i]) - image_of(tiled).data()[i], 2);
    EXPECT_LT(std::sqrt(squares / static_cast<double>(image_of(whole).size())),
              2.0 * kTolerance * whole.statistics.at(0).std);
  }
}

TEST_F(SimulateChainTiles, ReportsAreSumsOverAllTiles) {
  // A small full well, below a part of the scene, and a converter that is short of both ends.
  const mtf::io::SensorConfig config = sensor(
      "[defects]\ndead_fraction = 0.01\n[noise]\nseed = 3\n[adc]\nbits = 14\nelectrons_per_count = \"500 e-\"\noffset "
      "= "
      "-15000\n",
      "\"10 Me-\"", "\"6.96 Me-\"");
  const SimulateResult whole = run(config, {.tolerance = kTolerance});
  const SimulateResult tiled = run(config, tiles_to_file());
  const Json expected = chain_of(whole), found = chain_of(tiled);
  EXPECT_EQ(found["saturation"]["pixels"], expected["saturation"]["pixels"]);
  EXPECT_EQ(found["saturation"]["pixels"].get<std::int64_t>() +
                found["saturation"]["defective_or_blinking"]["pixels"].get<std::int64_t>(),
            kColumns * kRows);
  for (const char* name : {"pixels_at_full_well", "pixels_at_least_count"}) {
    EXPECT_GT(found[name].get<std::int64_t>(), kColumns * kRows / 20) << found;
    EXPECT_NEAR(found[name].get<double>(), expected[name].get<double>(), 1e-3 * kColumns * kRows) << name;
  }
  EXPECT_EQ(found["stages"], expected["stages"]);
  EXPECT_TRUE(found["timing_ms"].contains("shot")) << found;
  EXPECT_FALSE(tiled.report.warnings.empty());
  EXPECT_EQ(tiled.report.warnings.size(), whole.report.warnings.size());
  EXPECT_NEAR(tiled.statistics.at(0).std, whole.statistics.at(0).std, 1e-2);
  EXPECT_EQ(read(scratch / "out.exr").height(), kRows);
  EXPECT_LE(static_cast<std::int64_t>(tiled.report.tiles->plan.bytes), kMemory);
}

TEST_F(SimulateChainTiles, TheSameBitsForAnyNumberOfThreads) {
  const mtf::io::SensorConfig config = sensor(kPixelwise);
  SimulateOptions options{.tolerance = 1e-3, .memory = kMemory, .threads = 3};
  const SimulateResult three = run(config, options);
  options.threads = 1;
  const SimulateResult one = run(config, options);
  EXPECT_EQ(share_of_other_counts(image_of(one), image_of(three)), 0.0);
  EXPECT_EQ(chain_of(one)["saturation"], chain_of(three)["saturation"]);
}

TEST_F(SimulateChainTiles, ARegionIsThatPartOfTheImage) {
  const mtf::io::SensorConfig config = sensor(kPixelwise);
  SimulateOptions options{.tolerance = kTolerance, .region = std::array<std::int64_t, 4>{101, 57, 150, 90}};
  const SimulateResult whole = run(config, options);
  options.memory = std::int64_t{300} << 20;
  const SimulateResult tiled = run(config, options);
  EXPECT_LT(share_of_other_counts(image_of(whole), image_of(tiled)), 1e-3);
  EXPECT_EQ(tiled.report.chain->held.pixels + tiled.report.chain->held_defects.pixels, 150 * 90);
}

TEST_F(SimulateChainTiles, ASinkGetsTilesOfCounts) {
  const mtf::io::SensorConfig config = sensor(kConverter);
  const SimulateResult expected = run(config, {.tolerance = 1e-3, .memory = kMemory});
  Image assembled(kColumns, kRows);
  std::mutex lock;
  SimulateOptions options{.tolerance = 1e-3, .memory = kMemory};
  options.sink = [&](const apps::ImagePart& part) {
    const std::scoped_lock guard(lock);
    EXPECT_EQ(part.metadata.text.at("mtf:units"), "counts");
    for (std::int64_t y = 0; y < part.region.height; ++y)
      for (std::int64_t x = 0; x < part.region.width; ++x)
        assembled.at(part.region.x + x, part.region.y + y) = part.planes[0].at(x, y);
  };
  run(config, options);
  EXPECT_EQ(share_of_other_counts(assembled, image_of(expected)), 0.0);
}

TEST_F(SimulateChainTiles, ACancelledRunGoesOnWithItsCounts) {
  const mtf::io::SensorConfig config = sensor(kPixelwise, "\"10 Me-\"", "\"6.96 Me-\"");
  const SimulateResult expected = run(config, {.tolerance = 1e-3, .memory = kMemory});
  SimulateOptions options = tiles_to_file(1e-3);
  options.watch = [](const SimulateEvent& event) { return event.text != "tiles" || event.value < 0.5; };
  EXPECT_THROW(run(config, options), apps::Cancelled);
  EXPECT_FALSE(fs::exists(scratch / "out.exr"));
  options.watch = nullptr;
  options.stage = radiometry::OutputStage::electrons;  // another image: nothing of the stopped run is of use
  EXPECT_EQ(run(config, options).report.tiles->tally.resumed, 0);

  options = tiles_to_file(1e-3);
  std::atomic<int> tiles = 0;
  options.watch = [&](const SimulateEvent& event) { return event.text != "tiles" || ++tiles < 3; };
  EXPECT_THROW(run(config, options), apps::Cancelled);
  options.watch = nullptr;
  const SimulateResult resumed = run(config, options);
  EXPECT_GT(resumed.report.tiles->tally.resumed, 0);
  EXPECT_EQ(share_of_other_counts(read(scratch / "out.exr"), image_of(expected)), 0.0);
  EXPECT_EQ(chain_of(resumed)["saturation"], chain_of(expected)["saturation"]);
  EXPECT_EQ(resumed.report.chain->well.high, expected.report.chain->well.high);
  EXPECT_FALSE(fs::exists(scratch / "out.exr.part"));
}

TEST_F(SimulateChainTiles, StagesThatNeedTheWholeImageAreRefusedByName) {
  const SimulateOptions options = tiles_to_file();
  const auto refuse = [&](const std::string& more, const std::string& stage, const std::string& hint) {
    expect_refused(sensor(more + kConverter), options, {"--memory", "s.toml", stage + " (", hint});
  };
  refuse("[distortion]\nk1 = -0.05\n", "distortion", "remove their tables");
  refuse("[veiling_glare]\nfraction = 0.03\n", "veiling glare", "remove their tables");
  refuse("[ghost]\nfraction = 0.01\n", "ghost", "remove their tables");
  refuse("[blooming]\n", "blooming", "--stage irradiance");
  refuse("[[readout]]\nkind = \"gaussian\"\nsigma = \"4 um\"\n", "readout", "--stage irradiance");
  refuse("[correction]\n", "correction", "--stage dn");
  refuse("[[postsample]]\nkind = \"fir\"\ntaps = [[0, -0.25, 0], [-0.25, 2.0, -0.25], [0, -0.25, 0]]\n", "postsample",
         "--stage dn");
  refuse("[agc]\n", "agc", "--stage dn");
}

// The samples of a microscan are finer than the pitch from the first stage on: the image of no stage has tiles.
TEST_F(SimulateChainTiles, AMicroscanIsRefusedAtEveryStage) {
  const mtf::io::SensorConfig config = sensor("[microscan]\nsteps = 2\n" + kConverter);
  for (const auto stage : {radiometry::OutputStage::radiance, radiometry::OutputStage::irradiance,
                           radiometry::OutputStage::electrons, radiometry::OutputStage::dn}) {
    SimulateOptions options = tiles_to_file();
    options.stage = stage;
    expect_refused(config, options, {"--memory", "s.toml", "microscan (", "leave out --memory"});
    try {
      run(config, options);
    } catch (const mtf::UsageError& error) {
      EXPECT_FALSE(says(error.what(), "--stage")) << error.what();
    }
  }
}

TEST_F(SimulateChainTiles, AreChosenOnlyWhereTheyCanMakeTheImage) {
  const auto chosen = [&](const mtf::io::SensorConfig& config, const SimulateOptions& options = {},
                          const std::string& scene = "scene.exr", double machine_bytes = 1.0) {
    return apps::wants_tiles(apps::SensorRun(config, options.stage), {.file = (scratch / scene).string()}, options,
                             machine_bytes);
  };
  EXPECT_TRUE(chosen(sensor(kConverter)));
  EXPECT_FALSE(chosen(sensor(kConverter), {}, "scene.exr", 1e12));
  EXPECT_TRUE(chosen(sensor(kConverter), {.out = (scratch / "out.exr").string()}));
  EXPECT_FALSE(chosen(sensor(kConverter), {.out = (scratch / "out.png").string()}));
  EXPECT_FALSE(chosen(sensor(kConverter), {.out = (scratch / "out.tif").string()}));
  EXPECT_FALSE(chosen(sensor(kConverter), {.nan = apps::NanPolicy::fill}));
  EXPECT_FALSE(chosen(sensor("[agc]\n" + kConverter)));
  EXPECT_TRUE(chosen(sensor("[agc]\n" + kConverter), {.stage = radiometry::OutputStage::dn}));
  write_scene("counts.exr", 5000.0, 300.0, "counts");
  EXPECT_FALSE(chosen(sensor(kConverter), {}, "counts.exr"));
  EXPECT_TRUE(chosen(sensor(kConverter), {.memory = kMemory}, "counts.exr"));  // asked for: refused by name
  EXPECT_FALSE(chosen(sensor(kConverter, "quantity = \"temperature\"",
                             "quantity = \"temperature\"\nemissivity_channel = \"e\"\nsurroundings = \"280 K\"")));
  write_file(scratch / "path.csv",
             "range_m,wavelength_um,transmission,radiance_w_m2_sr_um\n1000,3,0.8,0.01\n1000,5,0.8,0.01\n");
  EXPECT_FALSE(chosen(sensor("[path]\ntable = \"path.csv\"\n" + kConverter, "quantity = \"temperature\"",
                             "quantity = \"temperature\"\ndepth_channel = \"Z\"")));
}

TEST_F(SimulateChainTiles, MapsAreCheckedBeforeTheSceneIsRead) {
  Image small(10, 10);
  std::fill_n(small.data(), small.size(), 1.0F);
  mtf::io::write_exr((scratch / "small.exr").string(), {{"Y", small.view()}}, {});
  SimulateOptions options = tiles_to_file();
  bool scene_read = false;
  options.watch = [&](const SimulateEvent& event) {
    scene_read = scene_read || event.text == "range";
    return true;
  };
  for (const std::string key : {"[vignetting]\nmap", "[nonuniformity]\nresponsivity", "[nonuniformity]\noffset"})
    expect_refused(sensor(key + " = \"small.exr\"\n" + kConverter), options, {"s.toml:", "10x10", "425x365"});
  EXPECT_FALSE(scene_read);
}

TEST_F(SimulateChainTiles, LightBeyondFloatIsCalledSo) {
  write_scene("bright.exr", 1e20, 1e18, "radiance");
  const auto message = [&](const SimulateOptions& options) -> std::string {
    try {
      run(sensor(kConverter), options, "bright.exr");
    } catch (const mtf::RuntimeError& error) {
      return error.what();
    }
    return "nothing was thrown";
  };
  const std::string whole = message({}), tiled = message(tiles_to_file({}));
  EXPECT_EQ(tiled, whole);
  expect_says(tiled, {"3.4e38"});
}

TEST_F(SimulateChainTiles, ARunOfAnotherRegionStartsOver) {
  const mtf::io::SensorConfig config = sensor(kConverter);
  SimulateOptions options = tiles_to_file(1e-3);
  options.memory = std::int64_t{300} << 20;
  options.region = std::array<std::int64_t, 4>{0, 0, 200, 180};
  options.watch = [](const SimulateEvent& event) { return event.text != "tiles" || event.value < 0.5; };
  EXPECT_THROW(run(config, options), apps::Cancelled);
  EXPECT_GT(fs::file_size(scratch / "out.exr.part.tiles"), 90U);  // a tile is there
  options.watch = nullptr;
  options.region = std::array<std::int64_t, 4>{200, 180, 200, 180};
  const SimulateResult other = run(config, options);
  EXPECT_EQ(other.report.tiles->tally.resumed, 0);
  options.out = "";
  EXPECT_EQ(share_of_other_counts(read(scratch / "out.exr"), image_of(run(config, options))), 0.0);
}

TEST_F(SimulateChainTiles, ScenesThatAreMoreThanTheirWindowsAreRefusedByName) {
  const SimulateOptions options = tiles_to_file();
  write_scene("counts.exr", 5000.0, 300.0, "counts");
  expect_refused(sensor(kConverter), options, {"counts.exr", "scene of counts"}, "counts.exr");
  expect_refused(sensor(kConverter, "quantity = \"temperature\"",
                        "quantity = \"temperature\"\nemissivity_channel = \"e\"\nsurroundings = \"280 K\""),
                 options, {"scene.emissivity_channel"});
  write_file(scratch / "path.csv",
             "range_m,wavelength_um,transmission,radiance_w_m2_sr_um\n1000,3,0.8,0.01\n1000,5,0.8,0.01\n");
  expect_refused(sensor("[path]\ntable = \"path.csv\"\n" + kConverter, "quantity = \"temperature\"",
                        "quantity = \"temperature\"\ndepth_channel = \"Z\""),
                 options, {"scene.depth_channel"});
  write_scene("cold.exr", 1.0, 3.0, "temperature");
  expect_refused(sensor(kConverter), options, {"below 0", "K", "scene.negative"}, "cold.exr");
  EXPECT_THROW(run(sensor(kConverter), {.memory = kMemory, .frames = apps::FrameRange{1, 2, 1}}), mtf::UsageError);
}

}  // namespace
}  // namespace apps_test
