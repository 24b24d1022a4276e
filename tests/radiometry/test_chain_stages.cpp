// SPDX-License-Identifier: Apache-2.0

// The table of the stages: which of them run, and what is said of them.

#include <gtest/gtest.h>

#include "tests/radiometry/chain_cases.h"
#include "tests/radiometry/expect_refused.h"

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

TEST(ChainStages, APlanForOtherFiltersIsRefused) {
  mtf::System<double> filtered = mwir_system();
  filtered.list(mtf::Stage::readout).push_back({mtf::test::gaussian(4.0), "gaussian"});
  const mtf::SensorPlan joint = mtf::compile_sensor(filtered, {16, 16, 15.0, 15.0}, {});
  test::expect_refused({"plan", "separate_readout"},
                       [&] { static_cast<void>(Chain(joint, filtered, noisy_sensor())); });
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
