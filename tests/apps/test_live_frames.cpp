// SPDX-License-Identifier: Apache-2.0

// Frames of the live view: which of the last ones are shown again, and that a preview never stands for the picture at
// rest where it has less.

#include "apps/live/frames.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "apps/sensor/sensor_air.h"

namespace apps::live {
namespace {

Sensor camera(const std::string& more = "") {
  auto result = mtf::io::parse_config(R"(schema = 1
name = "camera"
[frame]
focal_length = "100 mm"
pitch = "15 um"
integration_time = "10 ms"
[optics]
f_number = 2.5
[band]
wavelength = ["3 um", "5 um"]
[[presample]]
kind = "footprint"
width = "15 um"
[detector]
quantum_efficiency = 0.75
full_well = "10 Me-"
read_noise = "500 e-"
[noise]
seed = 4
)" + more,
                                      "camera.toml", sensor_schema());
  EXPECT_TRUE(result.ok());
  return std::make_shared<const mtf::io::SensorConfig>(std::move(result.config));
}

FrameMaker maker() {
  mtf::io::Scene scene;
  scene.names = {"Y"};
  scene.quantity = mtf::io::Quantity::temperature;
  scene.grid = {64, 48, 15.0, 15.0};
  mtf::Image plane(64, 48);
  for (std::int64_t i = 0; i < plane.size(); ++i) plane.data()[i] = 300.0F + static_cast<float>(i % 37);
  scene.planes.push_back(std::move(plane));
  return {SceneSource{.image = std::move(scene)}, {.threads = 1}};
}

bool same_pixels(const KeptFrame& a, const KeptFrame& b) {
  const mtf::Image &p = a.image.planes.at(0), &q = b.image.planes.at(0);
  return p.size() == q.size() && std::equal(p.data(), p.data() + p.size(), q.data());
}

TEST(FrameMaker, APreviewWithoutTheNoiseOfAllRowsIsNotThePictureAtRest) {
  const Sensor sensor = camera();
  FrameMaker frames = maker(), others = maker();
  const auto preview = frames.frame(sensor, {.number = 2, .preview = true, .every = 3});
  EXPECT_EQ(preview->noise_rows, 3);
  EXPECT_TRUE(preview->passing);
  const auto rest = frames.frame(sensor, {.number = 2});
  EXPECT_NE(rest->id, preview->id);
  EXPECT_EQ(rest->noise_rows, 1);
  EXPECT_FALSE(rest->passing);
  EXPECT_FALSE(same_pixels(*rest, *preview));
  EXPECT_TRUE(same_pixels(*rest, *others.frame(sensor, {.number = 2})));
  // It does for the same asked once more, as a preview or not.
  EXPECT_EQ(frames.frame(sensor, {.number = 2}), rest);
  EXPECT_EQ(frames.frame(sensor, {.number = 2, .preview = true, .every = 3}), rest);
}

TEST(FrameMaker, WhatIsAskedOtherwiseIsMadeAnew) {
  const Sensor sensor = camera();
  FrameMaker frames = maker();
  const auto first = frames.frame(sensor, {});
  // Each beside the one before it, from which it differs in one respect.
  for (const FrameRequest& request : {FrameRequest{.number = 1}, FrameRequest{.tolerance = 1e-3},
                                      FrameRequest{.stage = radiometry::OutputStage::electrons}}) {
    const auto before = frames.frame(sensor, {});
    EXPECT_TRUE(same_pixels(*before, *first));
    EXPECT_NE(frames.frame(sensor, request)->id, before->id);
  }
  const auto before = frames.frame(sensor, {});
  EXPECT_NE(frames.frame(camera("[adc]\nbits = 14\n"), {})->id, before->id);
}

TEST(FrameMaker, ThePreviewOfA3dSceneIsDrawnAnewAtRest) {
  int drawn = 0;
  FrameMaker frames([&](const Sensor&, const FrameRequest& request) {
    ++drawn;
    KeptFrame frame{.names = {"Y"}, .passing = request.preview};
    frame.image.planes.emplace_back(4, 4);
    return frame;
  });
  const Sensor sensor = camera();
  frames.frame(sensor, {.preview = true});
  frames.frame(sensor, {.preview = true});
  EXPECT_EQ(drawn, 1);
  frames.frame(sensor, {});
  frames.frame(sensor, {});
  EXPECT_EQ(drawn, 2);
  frames.frame(sensor, {.from = Viewpoint{.utc_s = 60.0}});
  EXPECT_EQ(drawn, 3);
}

TEST(FrameMaker, TheLastFramesAreKeptByTheirNumbers) {
  FrameMaker frames([](const Sensor&, const FrameRequest&) { return KeptFrame{}; }, 1000);
  const Sensor sensor = camera();
  for (std::int64_t number = 0; number < 20; ++number)
    EXPECT_EQ(frames.frame(sensor, {.number = number})->id, 1001U + static_cast<std::uint64_t>(number));
  EXPECT_EQ(frames.kept(1020)->id, 1020U);
  EXPECT_EQ(frames.kept(1018)->id, 1018U);
  EXPECT_EQ(frames.kept(1001), nullptr);
  EXPECT_EQ(frames.kept(1021), nullptr);
}

}  // namespace
}  // namespace apps::live
