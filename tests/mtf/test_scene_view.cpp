// SPDX-License-Identifier: Apache-2.0
#include "mtf/plan/plan.h"

#include <gtest/gtest.h>

#include "mtf/error.h"
#include "mtf/literals.h"
#include "mtf/plan/sensor_plan.h"
#include "tests/mtf/builders.h"
#include "tests/mtf/plan_support.h"
#include "tests/mtf/reference.h"

namespace mtf::test {
namespace {

using namespace mtf::literals;

// What one call does is what its steps do by hand, to the bit.
TEST(SceneView, plan_equals_that_of_the_steps) {
  const System<double> system = mwir();
  const Image scene = random_image(96, 64, 3);
  for (const Border border : {Border::reflect, Border::constant}) {
    const double level = border == Border::constant ? 30.0 : 0.0;
    const PlanOptions options = options_for(scene, border, 1e-4, level);
    const SampleGrid in{96, 64, 3.75, 3.75}, out = detector_grid(system, in);
    const Plan by_hand = compile(system, in, out, options);
    PlanOptions unknown = options;
    unknown.scene = SceneSummary{1e6, 1e6, 1.0, 1.0, 1.0};  // of some other scene
    const Plan plan = compile(system, {scene.view(), 3.75_um, level}, unknown);
    EXPECT_EQ(plan.explain(), by_hand.explain());
    EXPECT_EQ(plan.out(), out);
    Image expected(out.width, out.height), image(out.width, out.height);
    by_hand.run(scene.view(), expected.view(), level);
    plan.run(scene.view(), image.view(), level);
    EXPECT_TRUE(same_bits(image, expected));
  }
}

TEST(SceneView, sensor_plan_equals_that_of_the_steps) {
  System<double> system = mwir();
  system.add(Stage::postsample, fir({{0, -0.25, 0}, {-0.25, 2.0, -0.25}, {0, -0.25, 0}}));
  const Image image = random_image(96, 64, 4);
  const SceneView scene{image.view(), 3.75_um, 20.0};
  PlanOptions options;
  options.border = Border::constant;
  const SensorPlan plan = compile_sensor(system, scene, options);
  const SensorPlan by_hand =
      compile_sensor(system, grid_of(scene, system.frame), options_for(image, Border::constant, 1e-4, 20.0));
  EXPECT_EQ(plan.predicted_error, by_hand.predicted_error);
  EXPECT_TRUE(same_bits(plan.run(scene), by_hand.run(std::span(&scene.samples, 1), 20.0).front()));
}

TEST(SceneView, step_as_length_angle_or_pixels) {
  Frame<double> frame = mwir().frame;
  frame.pitch_y_um = 30.0;
  const Image image(8, 4);
  const auto grid = [&](const AxisPair<double>& step) { return grid_of({image.view(), step}, frame); };
  EXPECT_EQ(grid(3.75_um), (SampleGrid{8, 4, 3.75, 3.75}));
  EXPECT_EQ(grid(0.25_px), (SampleGrid{8, 4, 3.75, 7.5}));
  EXPECT_EQ(grid(50_urad), (SampleGrid{8, 4, 5.0, 5.0}));
  EXPECT_EQ(grid({3.75_um, 0.5_px}), (SampleGrid{8, 4, 3.75, 15.0}));
  EXPECT_THROW(grid({}), UsageError);
}

TEST(SceneView, scene_that_a_plan_was_not_made_for_is_refused) {
  const Image image = random_image(64, 64, 5), smaller = random_image(32, 64, 5);
  const SensorPlan plan = compile_sensor(mwir(), SceneView{image.view(), 3.75_um}, {});
  EXPECT_THROW(plan.run(SceneView{smaller.view(), 3.75_um}), UsageError);
  EXPECT_THROW(plan.run(SceneView{image.view(), 7.5_um}), UsageError);
  EXPECT_NO_THROW(plan.run(SceneView{image.view(), 0.25_px}));
}

// A uniform scene has no contrast that an error could be relative to: every tolerance is met.
TEST(SceneView, uniform_scene) {
  Image image(32, 32);
  for (std::int64_t i = 0; i < image.size(); ++i) image.data()[i] = 7.0F;
  const SceneView scene{image.view(), 3.75_um};
  const Image seen = compile_sensor(mwir(), scene, {}).run(scene);
  for (std::int64_t i = 0; i < seen.size(); ++i) ASSERT_EQ(seen.data()[i], 7.0F);
}

}  // namespace
}  // namespace mtf::test
