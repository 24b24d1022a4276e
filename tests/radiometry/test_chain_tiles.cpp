// SPDX-License-Identifier: Apache-2.0

// The chain in tiles against the chain of the whole image, from the same sampled radiance: the same bits.

#include "radiometry/chain/chain_tiles.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/expect_error.h"
#include "tests/radiometry/chain_cases.h"
#include "tests/radiometry/thermal_cases.h"

namespace radiometry {
namespace {

using test::make_chain;
using test::mwir_system;
using test::noisy_sensor;

constexpr std::int64_t kWidth = 61, kHeight = 47;
constexpr double kStep_um = 15.0;

/// Every stage that acts on each pixel for itself.
Sensor pixelwise_sensor() {
  Sensor sensor = noisy_sensor();
  SensorSettings& s = sensor.settings;
  s.optics->temperature_k = 290.0;
  s.optics->emissivity = 0.15;
  s.vignetting = Vignetting{.cos4 = true};
  s.narcissus = Narcissus{.depth = 0.2, .radius = 0.3};
  s.defects = Defects{.dead_fraction = 0.01, .hot_fraction = 0.02, .hot_e = 5e5};
  s.blinking = Blinking{.fraction = 0.05, .excess_e = 4e5};
  s.nonlinearity = Nonlinearity{.a2 = -0.05};
  s.flicker = Flicker{.white_e = 500.0, .corner_cy_px = 0.05};
  s.frame_flicker = FlickerOctaves{.octave_e = 200.0};
  s.noise->fixed_row_e = 70.0;
  s.noise->fixed_column_e = 80.0;
  s.noise_3d = Noise3d{.t = 90.0, .v = 20.0, .h = 30.0, .tv = 40.0, .th = 50.0, .vh = 60.0, .tvh = 70.0};
  return sensor;
}

/// A ramp that ends beyond the full well.
mtf::Image ramp(double electrons_per_radiance) {
  mtf::Image image(kWidth, kHeight);
  for (std::int64_t y = 0; y < kHeight; ++y)
    for (std::int64_t x = 0; x < kWidth; ++x)
      image.at(x, y) = static_cast<float>((1e6 + 1.3e5 * static_cast<double>(x) + 1e3 * static_cast<double>(y)) /
                                          electrons_per_radiance);
  return image;
}

mtf::Image cut(const mtf::Image& image, const mtf::Region& region) {
  mtf::Image part(region.width, region.height);
  for (std::int64_t y = 0; y < region.height; ++y)
    std::copy_n(image.view().row(region.y + y) + region.x, region.width, part.view().row(y));
  return part;
}

/// Tiles of 16 x 13 pixels, which divide neither side of the image.
std::vector<mtf::Region> tiles() {
  std::vector<mtf::Region> regions;
  for (std::int64_t y = 0; y < kHeight; y += 13)
    for (std::int64_t x = 0; x < kWidth; x += 16)
      regions.push_back({x, y, std::min<std::int64_t>(16, kWidth - x), std::min<std::int64_t>(13, kHeight - y)});
  return regions;
}

void expect_tiles_of_the_whole(const mtf::System<double>& system, const Sensor& sensor, OutputStage stage) {
  const Chain whole = make_chain(system, sensor, kWidth, kHeight, kStep_um);
  const mtf::Image scene = ramp(whole.electrons_per_radiance());
  constexpr std::uint32_t kFrame = 5;
  const mtf::Image sampled = whole.run(scene.clone(), kFrame, OutputStage::radiance).image;
  const ChainFrame expected = whole.run(scene.clone(), kFrame, stage);

  const TiledChain tiled(mtf::compile_sensor(system, {16, 16, kStep_um, kStep_um}, {}), system, sensor, kWidth, kHeight,
                         stage);
  Clipped well, adc;
  HeldPixels held, held_defects;
  for (const mtf::Region& region : tiles()) {
    const ChainFrame tile = tiled.run(cut(sampled, region), {region.x, region.y}, kFrame, 1);
    const mtf::Image same = cut(expected.image, region);
    for (std::int64_t i = 0; i < same.size(); ++i)
      ASSERT_EQ(tile.image.data()[i], same.data()[i]) << region.x << " " << region.y << " " << i;
    well.high += tile.well.high;
    adc.low += tile.adc.low;
    adc.high += tile.adc.high;
    held += tile.held;
    held_defects += tile.held_defects;
  }
  EXPECT_EQ(well.high, expected.well.high);
  EXPECT_EQ(adc.low, expected.adc.low);
  EXPECT_EQ(adc.high, expected.adc.high);
  EXPECT_EQ(held, expected.held);
  EXPECT_EQ(held_defects, expected.held_defects);
}

TEST(ChainTiles, HaveThePixelsAndCountsOfTheWholeImage) {
  const Sensor sensor = pixelwise_sensor();
  for (const OutputStage stage :
       {OutputStage::radiance, OutputStage::irradiance, OutputStage::electrons, OutputStage::dn})
    expect_tiles_of_the_whole(mwir_system(), sensor, stage);
  const ChainFrame whole = make_chain(mwir_system(), sensor, kWidth, kHeight, kStep_um)
                               .run(test::flat(kWidth, kHeight, 1e30F), 0, OutputStage::dn);
  EXPECT_GT(whole.held.full_well, 0);
}

/// Of an uncooled camera that has warmed since its shutter closed, with a lens that vignettes.
TEST(ChainTiles, HaveTheFalseOffsetOfAThermalCamera) {
  mtf::System<double> system = test::lwir_system();
  system.frame.pitch_x_um = system.frame.pitch_y_um = kStep_um;
  ThermalSettings thermal = test::by_netd();
  thermal.shutter_k = 295.0;
  thermal.drift_k_s = 2.0;
  thermal.shutter_frames = 3;
  Sensor sensor = test::sensor_of(thermal);
  sensor.settings.frame = FrameSettings{.frame_time_s = 20e-3};
  sensor.settings.optics = OpticsSettings{.stop_temperature_k = 295.0};
  sensor.settings.vignetting = Vignetting{};
  sensor.settings.nonuniformity = NonuniformitySettings{.prnu = 0.02};
  sensor.settings.noise = NoiseSettings{.seed = 2};
  for (const OutputStage stage : {OutputStage::watts, OutputStage::volts})
    expect_tiles_of_the_whole(system, sensor, stage);
}

TEST(ChainTiles, TakeTheirPartOfMapsOfTheDetector) {
  mtf::System<double> system = mwir_system();
  system.frame.columns = kWidth;
  system.frame.rows = kHeight;
  const auto map = [](double mean, double step) {
    mtf::Image image(kWidth, kHeight);
    for (std::int64_t i = 0; i < image.size(); ++i)
      image.data()[i] = static_cast<float>(mean + step * static_cast<double>(i % 53));
    return std::make_shared<const mtf::Image>(std::move(image));
  };
  Sensor sensor = noisy_sensor();
  sensor.settings.vignetting = Vignetting{.map = "made.exr"};
  sensor.responsivity = map(0.9, 0.003);
  sensor.offset = map(-2000.0, 90.0);
  sensor.vignetting = map(0.5, 0.009);
  EXPECT_EQ(map_bytes(sensor), 3 * 4 * kWidth * kHeight);
  expect_tiles_of_the_whole(system, sensor, OutputStage::dn);

  sensor.offset = std::make_shared<const mtf::Image>(3, 3);
  expect_refused({"nonuniformity.offset", "3x3"}, [&] {
    TiledChain(mtf::compile_sensor(system, {16, 16, kStep_um, kStep_um}, {}), system, sensor, kWidth, kHeight,
               OutputStage::dn);
  });
}

TEST(ChainTiles, MapsAreCheckedAsAWholeBeforeTheFirstTile) {
  const auto map = [](std::int64_t x, std::int64_t y, float value) {
    mtf::Image image = test::flat(kWidth, kHeight, 0.5F);
    image.at(x, y) = value;
    return std::make_shared<const mtf::Image>(std::move(image));
  };
  const auto refused = [](const Sensor& sensor, std::initializer_list<std::string_view> parts) {
    expect_refused(parts, [&] {
      TiledChain(mtf::compile_sensor(mwir_system(), {16, 16, kStep_um, kStep_um}, {}), mwir_system(), sensor, kWidth,
                 kHeight, OutputStage::dn);
    });
  };
  Sensor corners = noisy_sensor(), factors = noisy_sensor(), offsets = noisy_sensor();
  corners.settings.vignetting = Vignetting{.map = "made.exr"};
  corners.vignetting = map(40, 30, std::nanf(""));
  refused(corners, {"vignetting.map: made.exr", "nan at pixel 40, 30"});
  factors.settings.nonuniformity = offsets.settings.nonuniformity = NonuniformitySettings{};
  factors.responsivity = map(60, 46, -0.5F);
  refused(factors, {"nonuniformity.responsivity", "-0.5 at pixel 60, 46"});
  offsets.offset = map(0, 46, INFINITY);
  refused(offsets, {"nonuniformity.offset", "inf at pixel 0, 46"});
}

TEST(ChainTiles, PixelsBeyondTheDetectorAreRefused) {
  Sensor sensor = noisy_sensor();
  sensor.settings.nonuniformity = NonuniformitySettings{};
  sensor.responsivity = std::make_shared<const mtf::Image>(test::flat(kWidth, kHeight, 0.5F));
  const TiledChain tiled(mtf::compile_sensor(mwir_system(), {16, 16, kStep_um, kStep_um}, {}), mwir_system(), sensor,
                         kWidth, kHeight, OutputStage::electrons);
  expect_refused({"16 x 13", "column 50, row 40", "61 x 47"}, [&] {
    tiled.run(test::flat(16, 13, 1.0F), {50, 40}, 0);
  });
  EXPECT_NO_THROW(tiled.run(test::flat(16, 13, 1.0F), {kWidth - 16, kHeight - 13}, 0));
}

TEST(ChainTiles, StagesThatNeedTheWholeImageAreNamed) {
  const auto named = [](const auto& change, OutputStage stage) {
    Sensor sensor = noisy_sensor();
    change(sensor.settings);
    return whole_image_stages(mwir_system(), sensor, stage);
  };
  EXPECT_EQ(named([](SensorSettings&) {}, OutputStage::dn), "");
  const auto glare = [](SensorSettings& s) { s.glare = VeilingGlare{.fraction = 0.1}; };
  EXPECT_EQ(named(glare, OutputStage::radiance), "veiling glare (adds the mean of the whole image)");
  const auto two = [](SensorSettings& s) {
    s.blooming = Blooming{};
    s.agc = AutomaticGain{};
  };
  EXPECT_EQ(named(two, OutputStage::irradiance), "");
  for (const OutputStage stage : {OutputStage::radiance, OutputStage::irradiance, OutputStage::dn})
    EXPECT_EQ(named([](SensorSettings& s) { s.microscan = Microscan{.steps = 2}; }, stage).find("microscan"), 0U);
  EXPECT_EQ(named(two, OutputStage::dn).find("blooming"), 0U);
  expect_says(named(two, OutputStage::display), {", agc"});
  expect_refused({"veiling glare"}, [&] {
    Sensor sensor = noisy_sensor();
    glare(sensor.settings);
    TiledChain(mtf::compile_sensor(mwir_system(), {16, 16, kStep_um, kStep_um}, {}), mwir_system(), sensor, kWidth,
               kHeight, OutputStage::dn);
  });
}

}  // namespace
}  // namespace radiometry
