// SPDX-License-Identifier: Apache-2.0

// The table of the stages: which of them run, and what is said of them.

#include <gtest/gtest.h>

#include "tests/expect_error.h"
#include "tests/radiometry/chain_cases.h"

namespace radiometry {
namespace {

using test::flat;
using test::make_chain;
using test::mwir_sensor;
using test::mwir_system;
using test::noisy_sensor;

TEST(ChainStages, StagesThatAreOffDoNotRun) {
  const auto stages = [](const Chain& chain, OutputStage stage) {
    std::string names;
    for (const auto& [name, ms] : chain.run(flat(16, 16, 1e18F), 0, stage).timing_ms) names += std::string(name) + ";";
    return names;
  };
  Sensor bare = mwir_sensor();
  bare.settings.detector->full_well_e = mtf::kInfinity;
  EXPECT_EQ(stages(make_chain(mwir_system(), bare, 16, 16, 15.0), OutputStage::electrons), "presample;collect;");
  const Chain all = make_chain(mwir_system(), noisy_sensor(), 16, 16, 15.0);
  EXPECT_EQ(stages(all, OutputStage::radiance), "presample;");
  EXPECT_EQ(stages(all, OutputStage::dn), "presample;collect;shot;full well;offset;read;rows and columns;adc;");
}

TEST(ChainStages, AStageOfNoEffectIsLeftOutInWordsAndInFrames) {
  Sensor sensor = noisy_sensor();
  const auto on = [&] {
    std::string names;
    for (const ChainStage& stage : chain_stages(mwir_system(), sensor))
      if (stage.on) names += stage.name + ";";
    return names;
  };
  const auto ran = [&] {
    std::string names;
    const Chain chain = make_chain(mwir_system(), sensor, 16, 16, 15.0);
    ChainState state;
    for (const auto& [name, ms] : chain.run(flat(16, 16, 1e18F), 0, OutputStage::dn, 0.0, 1, &state).timing_ms)
      names += std::string(name) + ";";
    return names;
  };
  const std::string said = on(), done = ran();
  sensor.settings.glare = VeilingGlare{};
  sensor.settings.defects = Defects{};
  sensor.settings.noise_3d = Noise3d{};
  sensor.settings.shutter = Shutter{.kind = ShutterKind::global};
  EXPECT_EQ(on(), said);
  EXPECT_EQ(ran(), done);
}

// A map that a program made has no file name: it acts all the same, and is said.
TEST(ChainStages, MapsWithoutANameAct) {
  Sensor sensor = mwir_sensor();
  sensor.settings.nonuniformity = NonuniformitySettings{};
  const auto mean = [&] {
    const Chain chain = make_chain(mwir_system(), sensor, 16, 16, 15.0);
    return static_cast<double>(chain.run(flat(16, 16, 1e18F), 0, OutputStage::electrons).image.at(3, 3));
  };
  const auto is_on = [&](std::string_view name) {
    for (const ChainStage& stage : chain_stages(mwir_system(), sensor))
      if (stage.name == name) return stage.on;
    return false;
  };
  const double bare = mean();
  EXPECT_FALSE(is_on("offsets"));
  sensor.offset = std::make_shared<const mtf::Image>(flat(16, 16, 1000.0F));
  EXPECT_NEAR(mean(), bare + 1000.0, 1e-6 * bare);
  EXPECT_TRUE(is_on("offsets"));
  sensor.responsivity = std::make_shared<const mtf::Image>(flat(16, 16, 0.5F));
  EXPECT_NEAR(mean(), 0.5 * bare + 1000.0, 1e-6 * bare);
  EXPECT_TRUE(is_on("responsivity"));
}

// A sequence may begin without [correction] or with another format: its later chains measure maps of their own.
TEST(ChainStages, ACorrectionIsTakenOnlyFromAChainThatHasItsMaps) {
  const auto chain_of = [](bool corrected, std::int64_t size, const Chain* before) {
    Sensor sensor = noisy_sensor();
    if (corrected) sensor.settings.correction = CorrectionSettings{};
    mtf::PlanOptions options;
    options.separate_readout = true;
    return Chain(mtf::compile_sensor(mwir_system(), {size, size, 15.0, 15.0}, options), mwir_system(), sensor, {}, 1,
                 before);
  };
  const Chain bare = chain_of(false, 16, nullptr), large = chain_of(true, 32, nullptr);
  const auto image = [](const Chain& chain) { return chain.run(flat(16, 16, 1e18F), 0, OutputStage::display).image; };
  const mtf::Image expected = image(chain_of(true, 16, nullptr));
  for (const Chain* before : {&bare, &large}) {
    const mtf::Image seen = image(chain_of(true, 16, before));
    EXPECT_TRUE(std::equal(seen.data(), seen.data() + seen.size(), expected.data()));
  }
}

// Maps of pixels are shared with an earlier chain where they are the same, and only there.
TEST(ChainStages, AnEarlierChainChangesNoImage) {
  const auto half = std::make_shared<const mtf::Image>(flat(24, 24, 0.5F));
  const auto changed = [](auto change) {
    Sensor sensor = noisy_sensor();
    sensor.settings.vignetting = Vignetting{};
    sensor.settings.optics->stop_temperature_k = 250.0;
    sensor.settings.defects = Defects{.dead_fraction = 0.02, .hot_fraction = 0.02, .hot_e = 1e5};
    change(sensor);
    return sensor;
  };
  const std::vector<Sensor> sensors{
      changed([](Sensor&) {}),
      changed([](Sensor& s) { s.settings.nonuniformity->prnu = 0.01; }),
      changed([](Sensor& s) { s.settings.defects->hot_e = 2e5; }),
      changed([](Sensor& s) { s.settings.noise->seed = 12; }),
      changed([](Sensor& s) { s.settings.detector->dark_e_s = 9e6; }),
      changed([](Sensor& s) { s.settings.vignetting.reset(); }),
      changed([&](Sensor& s) { s.settings.vignetting->cos4 = false, s.vignetting = half; }),
      changed([](Sensor& s) { s.settings.narcissus = Narcissus{.depth = 0.5}; }),
      changed([](Sensor& s) { s.settings.blinking = Blinking{.fraction = 0.1, .excess_e = 1e5}; }),
      changed([](Sensor& s) { s.settings.axis = OpticalAxis{.x_px = 5.0}; }),
      changed([&](Sensor& s) { s.responsivity = half; }),
      changed([](Sensor& s) { s.offset = std::make_shared<const mtf::Image>(flat(24, 24, 1000.0F)); })};
  mtf::System<double> blurred = mwir_system();
  blurred.add(mtf::Stage::presample, mtf::test::gaussian(4.0));
  blurred.frame.focal_length_mm *= 0.01;
  mtf::PlanOptions options;
  options.separate_readout = true;
  const mtf::SensorPlan sharp = mtf::compile_sensor(mwir_system(), {24, 24, 15.0, 15.0}, options);
  const mtf::SensorPlan soft = mtf::compile_sensor(blurred, {24, 24, 15.0, 15.0}, options);
  for (const Sensor& first : sensors) {
    const Chain before(sharp, mwir_system(), first, {}, 1);
    for (const Sensor& sensor : sensors) {
      const Chain after(soft, blurred, sensor, {}, 1, &before), alone(soft, blurred, sensor, {}, 1);
      const mtf::Image a = after.run(flat(24, 24, 1e18F), 3, OutputStage::dn).image;
      const mtf::Image b = alone.run(flat(24, 24, 1e18F), 3, OutputStage::dn).image;
      EXPECT_TRUE(std::equal(a.data(), a.data() + a.size(), b.data()))
          << &first - sensors.data() << " before " << &sensor - sensors.data();
    }
  }
}

TEST(ChainStages, APlanForOtherFiltersIsRefused) {
  mtf::System<double> filtered = mwir_system();
  filtered.list(mtf::Stage::readout).push_back({mtf::test::gaussian(4.0), "gaussian"});
  const mtf::SensorPlan joint = mtf::compile_sensor(filtered, {16, 16, 15.0, 15.0}, {});
  expect_refused({"plan", "separate_readout"}, [&] { static_cast<void>(Chain(joint, filtered, noisy_sensor())); });
}

TEST(ChainStages, ATableOfTheFileIsAStageInWords) {
  const auto on = [](const Sensor& sensor) {
    std::string names;
    for (const ChainStage& stage : chain_stages(mwir_system(), sensor))
      if (stage.on) names += stage.name + ";";
    return names;
  };
  EXPECT_EQ(on(mwir_sensor()), "presample;light;full well;");
  EXPECT_EQ(on(noisy_sensor()),
            "presample;light;responsivity;dark current;shot noise;full well;offsets;read noise;row and column "
            "noise;adc;");
}

}  // namespace
}  // namespace radiometry
