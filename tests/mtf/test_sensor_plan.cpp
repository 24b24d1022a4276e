// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>

#include "mtf/error.h"
#include "mtf/plan/sensor_plan.h"
#include "tests/mtf/builders.h"
#include "tests/mtf/reference.h"

namespace mtf::test {
namespace {

// All contrast in the corner that the format sees: the input of the filters after the sampling has more than the
// scene's std.
TEST(SensorPlan, promise_holds_for_filters_after_a_small_format) {
  System<double> system;
  system.frame = {100.0, 15.0, 15.0, 0.01, 8, 8};
  system.add(Stage::postsample, gaussian(1.5));
  const SampleGrid in{48, 48, 15.0, 15.0};
  Image scene(48, 48);
  for (std::int64_t y = 0; y < 48; ++y)
    for (std::int64_t x = 0; x < 48; ++x) scene.at(x, y) = x < 8 && y < 8 ? static_cast<float>((x + y) % 2) : 0.5F;
  PlanOptions options;
  options.tolerance = 1e-2;
  options.scene = summarise(scene.view(), options.border, 0.0);
  const SensorPlan plan = compile_sensor(system, in, options);
  const ImageView<const float> view = scene.view();
  const std::vector<Image> images = plan.run(std::span(&view, 1));
  Image sampled(8, 8);
  for (std::int64_t y = 0; y < 8; ++y)
    for (std::int64_t x = 0; x < 8; ++x) sampled.at(x, y) = scene.at(x, y);
  const SampleGrid out{8, 8, 15.0, 15.0};
  const auto expected = reference_image(sampled, out, out, otf_of(system, Stage::postsample), Border::reflect);
  double squares = 0.0;
  for (std::int64_t i = 0; i < 64; ++i)
    squares += std::pow(images[0].data()[i] - expected[static_cast<std::size_t>(i)], 2);
  const double rms = std::sqrt(squares / 64.0) / options.scene->std;
  EXPECT_LE(rms, plan.predicted_error);
  EXPECT_LE(plan.predicted_error, options.tolerance);
}

TEST(SensorPlan, in_place_equals_apart_and_refuses_other_sizes) {
  System<double> system = mwir();
  system.add(Stage::postsample, fir({{0, -0.25, 0}, {-0.25, 2.0, -0.25}, {0, -0.25, 0}}));
  const SampleGrid in{64, 48, 3.75, 3.75};
  const SensorPlan plan = compile_sensor(system, in, {});
  const Image scene = random_image(64, 48, 5);
  const ImageView<const float> view = scene.view();
  const std::vector<Image> apart = plan.run(std::span(&view, 1));
  std::vector<Image> planes;
  planes.push_back(scene.clone());
  const std::vector<Image> in_place = plan.run(std::move(planes));
  ASSERT_EQ(in_place[0].width(), 16);
  for (std::int64_t i = 0; i < apart[0].size(); ++i) ASSERT_EQ(in_place[0].data()[i], apart[0].data()[i]);
  std::vector<Image> wrong;
  wrong.push_back(scene.clone());
  wrong.push_back(random_image(8, 8, 1));
  EXPECT_THROW(plan.run(std::move(wrong)), UsageError);
}

std::vector<Image> run_plan(const SensorPlan& plan, const Image& scene) {
  const ImageView<const float> view = scene.view();
  return plan.run(std::span(&view, 1));
}

void expect_equal_bits(const std::vector<Image>& a, const std::vector<Image>& b) {
  ASSERT_EQ(a.size(), b.size());
  ASSERT_EQ(a[0].width(), b[0].width());
  ASSERT_EQ(a[0].height(), b[0].height());
  for (std::int64_t i = 0; i < a[0].size(); ++i) ASSERT_EQ(a[0].data()[i], b[0].data()[i]) << i;
}

System<double> sharpened(double blur_um, double centre) {
  System<double> system = mwir();
  system.add(Stage::presample, gaussian(blur_um));
  const double side = 0.25 * (1.0 - centre);
  system.add(Stage::postsample, fir({{0, side, 0}, {side, centre, side}, {0, side, 0}}));
  return system;
}

TEST(SensorPlan, with_remakes_the_lists_that_changed_and_no_more) {
  const SampleGrid in{96, 80, 3.75, 3.75};
  const Image scene = random_image(96, 80, 3);
  PlanOptions options;
  options.scene = summarise(scene.view(), options.border, 0.0);
  const SensorPlan plan = compile_sensor(sharpened(3.0, 2.0), in, options);

  const SensorPlan same = plan.with(sharpened(3.0, 2.0));
  EXPECT_TRUE(same.updated);
  EXPECT_EQ(&same.presample.report(), &plan.presample.report());
  EXPECT_EQ(&same.post->report(), &plan.post->report());

  const SensorPlan blurred = plan.with(sharpened(5.0, 2.0));
  EXPECT_TRUE(blurred.updated);
  EXPECT_NE(&blurred.presample.report(), &plan.presample.report());
  EXPECT_EQ(&blurred.post->report(), &plan.post->report());
  expect_equal_bits(run_plan(blurred, scene), run_plan(compile_sensor(sharpened(5.0, 2.0), in, options), scene));

  const SensorPlan softer = plan.with(sharpened(3.0, 1.5));
  EXPECT_EQ(&softer.presample.report(), &plan.presample.report());
  EXPECT_NE(&softer.post->report(), &plan.post->report());
  EXPECT_LE(softer.predicted_error, options.tolerance);
}

TEST(SensorPlan, with_compiles_anew_where_shares_or_grids_do_not_fit) {
  const SampleGrid in{96, 80, 3.75, 3.75};
  const Image scene = random_image(96, 80, 3);
  PlanOptions options;
  options.tolerance = 1e-2;
  options.scene = summarise(scene.view(), options.border, 0.0);
  const SensorPlan plan = compile_sensor(sharpened(3.0, 1.0), in, options);
  const auto expect_fresh = [&](const System<double>& system) {
    const SensorPlan other = plan.with(system);
    EXPECT_LE(other.predicted_error, options.tolerance);
    expect_equal_bits(run_plan(other, scene), run_plan(compile_sensor(system, in, options), scene));
    return other.updated;
  };
  // A gain of 1e4 after the sampling leaves the presample plan less of the tolerance than transforms in float keep.
  EXPECT_FALSE(expect_fresh(sharpened(3.0, 5000.0)));
  System<double> coarser = sharpened(3.0, 1.0);
  coarser.frame.pitch_x_um = coarser.frame.pitch_y_um = 30.0;
  EXPECT_FALSE(expect_fresh(coarser));
  System<double> bare = sharpened(3.0, 1.0);
  bare.list(Stage::postsample).clear();
  EXPECT_FALSE(expect_fresh(bare));
  System<double> invalid = sharpened(3.0, 1.0);
  set(invalid.list(Stage::presample).back().component, "sigma", -1.0, "um");
  EXPECT_THROW(plan.with(invalid), UsageError);
}

TEST(SensorPlan, a_detector_larger_than_the_scene_is_refused) {
  const System<double> system = mwir();
  EXPECT_THROW(compile(system, {64, 64, 3.75, 3.75}, {400, 400, 15.0, 15.0}, {}), UsageError);
}

}  // namespace
}  // namespace mtf::test
