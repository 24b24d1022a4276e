// SPDX-License-Identifier: Apache-2.0

// Whose correction an image of a live view has.

#include "apps/simulate/sensor_run.h"
#include "tests/apps/live_images.h"
#include "tests/expect_error.h"
#include "tests/replaced.h"

namespace apps_test {
namespace {

using LiveCorrection = LiveSimulation;

TEST_F(LiveCorrection, ACorrectionIsThatOfTheFirstImageOrItsOwn) {
  const auto with_dsnu = [&](const char* dsnu) {
    return camera("[nonuniformity]\nprnu = 0.02\ndsnu = \"" + std::string(dsnu) +
                  "\"\n[adc]\nbits = 14\n[correction]\nlow = 0.2\nhigh = 0.8\n");
  };
  const SensorConfig first = with_dsnu("10 e-"), second = with_dsnu("100 ke-");
  apps::LiveSimulation live(temperatures());
  image(live, first);
  // As the next frame of a sequence it keeps the correction of the first, which leaves the new offsets in the image.
  EXPECT_GT(difference(image(live, second), alone(temperatures(), second)), 0.1);
  EXPECT_LT(difference(image(live, second, 0, apps::CorrectionOf::own), alone(temperatures(), second)), 1e-2);
}

// For the moment an earlier correction serves a camera of other light, not one of other pixels.
TEST_F(LiveCorrection, AnEarlierCorrectionServesWhereOnlyLightHasChanged) {
  using enum apps::CorrectionOf;
  const auto with = [&](double f_number, const char* prnu) {
    SensorConfig made =
        camera("[nonuniformity]\nprnu = " + std::string(prnu) +
               "\ndsnu = \"2 ke-\"\n[adc]\nbits = 14\n[noise]\nseed = 3\n[lag]\ntime_constant = \"5 ms\"\n"
               "[correction]\nframes = 2\nlow = 0.2\nhigh = 0.8\n");
    made.system.optics.f_number = f_number;
    return made;
  };
  const SensorConfig first = with(2.0, "0.02"), darker = with(2.2, "0.02"), other = with(2.2, "0.05");
  const auto expect_own = [&](apps::LiveSimulation& live, const SensorConfig& shown, apps::CorrectionOf correction) {
    EXPECT_LT(difference(image(live, shown, 0, correction), alone(temperatures(), shown)), 1e-2);
    EXPECT_FALSE(live.correction_lags());
  };
  apps::LiveSimulation live(temperatures());
  expect_own(live, first, earlier);  // there is none before
  for (int i = 0; i < 2; ++i) {
    const double away = difference(image(live, darker, 0, earlier), alone(temperatures(), darker));
    EXPECT_TRUE(live.correction_lags());
    EXPECT_LT(away, 1e-3);  // flat frames are as bright, for their fill is given
  }
  expect_own(live, darker, own);
  image(live, first, 0, earlier);
  EXPECT_TRUE(live.correction_lags());
  expect_own(live, darker, earlier);  // whose correction is still there
  expect_own(live, other, earlier);
}

// What unequal dark current leaves follows the exposure, so that a correction of another camera does not serve.
TEST_F(LiveCorrection, UnequalDarkCurrentHasItsOwn) {
  using enum apps::CorrectionOf;
  const auto with = [&](double f_number) {
    SensorConfig made = camera(
        "[nonuniformity]\ndcnu = 0.3\n[adc]\nbits = 14\n[noise]\nseed = 3\n"
        "[correction]\nframes = 2\nlow = 0.2\nhigh = 0.8\n");
    made.system.optics.f_number = f_number;
    return made;
  };
  apps::LiveSimulation live(temperatures());
  image(live, with(2.0), 0, earlier);
  const SensorConfig darker = with(2.2);
  EXPECT_LT(difference(image(live, darker, 0, earlier), alone(temperatures(), darker)), 1e-2);
  EXPECT_FALSE(live.correction_lags());
}

// The shading that a correction takes away is that of its flat frames; its level is that of their mean.
TEST_F(LiveCorrection, AnEarlierCorrectionKeepsItsShading) {
  using enum apps::CorrectionOf;
  const auto with = [&](const std::string& focal_length, const std::string& vignetting) {
    std::string text =
        kSensor + vignetting +
        "[nonuniformity]\nprnu = 0.02\n[adc]\nbits = 14\n[correction]\nframes = 2\nlow = 0.2\nhigh = 0.8\n";
    text = replaced(text, "\"100 mm\"", "\"" + focal_length + "\"");
    return sensor(text);
  };
  const std::string dark = "[vignetting]\na2 = -0.3\n", bright = "[vignetting]\na2 = -0.1\n";
  for (const auto& [first, second] : {std::pair{with("3 mm", dark), with("2 mm", dark)},
                                      {with("3 mm", dark), with("3 mm", bright)},
                                      {with("3 mm", dark), with("3 mm", "")},
                                      {with("3 mm", ""), with("3 mm", bright)}}) {
    SCOPED_TRACE(second.text);
    apps::LiveSimulation live(temperatures());
    image(live, first, 0, earlier);
    // Rounding of flat frames to counts, which two frames do not average; with the shading alone kept, the level would
    // be off by 1.3.
    EXPECT_LT(difference(image(live, second, 0, earlier), alone(temperatures(), second)), 3e-3);
    EXPECT_TRUE(live.correction_lags());
    EXPECT_LT(difference(image(live, second, 0, own), alone(temperatures(), second)), 1e-2);
    // Before the correction the image has its own shading, at once.
    const apps::SimulateOptions counts{.stage = radiometry::OutputStage::dn};
    apps::LiveSimulation raw(temperatures(), counts), other(temperatures(), counts);
    const Image before = image(raw, first, 0, earlier), after = image(raw, second, 0, earlier);
    EXPECT_FALSE(raw.correction_lags());
    EXPECT_LT(difference(after, image(other, second)), 1e-2);
    EXPECT_GT(difference(before, after), 0.05);
  }
}

// What flat frames show, or what converts it, is not light.
TEST_F(LiveCorrection, SensorsWhoseFlatFramesDifferHaveCorrectionsOfTheirOwn) {
  const std::string base = kSensor +
                           "[vignetting]\n[nonuniformity]\nprnu = 0.02\n[noise]\nseed = 3\n[adc]\nbits = 14\n" +
                           "[correction]\nlow = 0.2\nhigh = 0.8\n";
  const auto with = [&](const std::string& from, const std::string& to) {
    std::string text = base;
    EXPECT_TRUE(says(text, from)) << from;
    return sensor(text.replace(text.find(from), from.size(), to));
  };
  const SensorConfig first = sensor(base);
  for (const auto& [from, to] : {std::pair{"f_number = 2.5", "f_number = 3"},
                                 {"\"100 mm\"", "\"80 mm\""},
                                 {"[vignetting]", "[vignetting]\na2 = -0.2"},
                                 {"transmission = 0.85", "transmission = 0.5"},
                                 {"quantum_efficiency = 0.75", "quantum_efficiency = 0.5"},
                                 {"\"500 e-\"", "\"100 e-\""},
                                 {"seed = 3", "seed = 3\nrow = \"50 e-\""}}) {
    EXPECT_TRUE(apps::nearly_same_correction(first, with(from, to))) << to;
    EXPECT_FALSE(apps::same_correction(first, with(from, to))) << to;
  }
  for (const auto& [from, to] : {std::pair{"pitch = \"15 um\"", "pitch = \"15 um\"\nformat = [16, 12]"},
                                 {"\"10 Me-\"", "\"5 Me-\""},
                                 {"seed = 3", "seed = 4"},
                                 {"seed = 3", "seed = 3\nfixed_row = \"50 e-\""},
                                 {"prnu = 0.02", "prnu = 0.03"},
                                 {"bits = 14", "bits = 12"},
                                 {"[detector]", "[[readout]]\nkind = \"gaussian\"\nsigma = \"4 um\"\n[detector]"}}) {
    EXPECT_FALSE(apps::nearly_same_correction(first, with(from, to))) << to;
    EXPECT_FALSE(apps::same_correction(first, with(from, to))) << to;
  }
}

TEST_F(LiveCorrection, ACorrectionIsMeasuredOfThePixelsThatItCorrects) {
  const std::string adc = "[nonuniformity]\nprnu = 0.02\n[adc]\nbits = 14\n";
  const SensorConfig raw = camera(adc), corrected = camera(adc + "[correction]\nlow = 0.2\nhigh = 0.8\n");
  SensorConfig coarse = corrected;
  coarse.system.frame.pitch_x_um = coarse.system.frame.pitch_y_um = 30.0;
  apps::LiveSimulation live(temperatures());
  for (const SensorConfig* shown : std::initializer_list<const SensorConfig*>{&raw, &corrected, &coarse})
    EXPECT_LT(difference(image(live, *shown), alone(temperatures(), *shown)), 1e-2);
}

}  // namespace
}  // namespace apps_test
