// SPDX-License-Identifier: Apache-2.0
// Tiles: the same image as the exact reference and as the whole-image route, within the tolerance, for every border.
#include "mtf/tiles.h"

#include "tests/mtf/plan_support.h"

namespace mtf::test {
namespace {

Image tiled(const TiledSensorPlan& plan, const Image& scene, double border_value, TileTally* tally = nullptr) {
  const ImageView<const float> view = scene.view();
  std::vector<Image> out = plan.run(std::span(&view, 1), border_value, tally);
  return std::move(out.front());
}

double rms_between(const Image& a, const Image& b) {
  double squares = 0.0;
  for (std::int64_t i = 0; i < a.size(); ++i) squares += std::pow(static_cast<double>(a.data()[i]) - b.data()[i], 2);
  return std::sqrt(squares / static_cast<double>(a.size()));
}

// Half dark, half bright, noise on both: what far tails carry matters.
Image two_halves(std::int64_t width, std::int64_t height) {
  Image scene = random_image(width, height, 11, 5.0, 0.3);
  for (std::int64_t y = 0; y < height; ++y)
    for (std::int64_t x = 0; x < width; ++x) scene.at(x, y) += 2 * x + y < width ? 0.0F : 3.0F;
  return scene;
}

TEST(Tiles, keep_the_promise_against_the_reference) {
  int cut = 0;
  for (const Border border : kBorders)
    for (const double ratio : {1.0, 2.0, 3.0, 3.7, 1.5})
      for (const double tolerance : {1e-2, 1e-4}) {
        const System<double> system = with(bare(), {gaussian(16.0), motion(4.0, 30.0)});
        const SampleGrid in = scene_grid(system, 51, 44, ratio, ratio);
        const Image scene = two_halves(in.width, in.height);
        const PlanOptions options = options_for(scene, border, tolerance, 2.0);
        const TiledSensorPlan plan = compile_tiled(system, in, options, {.threads = 1, .side = 5});
        cut += plan.report().whole ? 0 : 1;
        const Image out = tiled(plan, scene, 2.0);
        const auto expected = reference_image(scene, in, plan.out(), otf_of(system, Stage::presample), border, 2.0);
        EXPECT_LE(rms_distance(out, expected) / options.scene->std, plan.report().predicted_error)
            << kBorderNames[static_cast<std::size_t>(border)] << " " << ratio << " " << tolerance << " "
            << plan.report().reason;
        EXPECT_LE(plan.report().predicted_error, tolerance);
      }
  EXPECT_GT(cut, 24) << "too few of the cases are tiles at all";
}

TEST(Tiles, split_otf_equals_the_whole_image) {
  int split = 0;
  for (const Border border : kBorders)
    for (const bool filters : {false, true})
      for (const double tolerance : {1e-2, 1e-3, 1e-4}) {
        System<double> system = mwir();
        if (filters) system.add(Stage::postsample, fir({{0, -0.25, 0}, {-0.25, 2.0, -0.25}, {0, -0.25, 0}}));
        const SampleGrid in{1203, 1010, 3.75, 3.75};
        const Image scene = two_halves(in.width, in.height);
        const PlanOptions options = options_for(scene, border, tolerance, 2.0);
        const TiledSensorPlan plan = compile_tiled(system, in, options, {.threads = 2, .side = 96});
        split += plan.report().every > 0 ? 1 : 0;
        const SensorPlan all = compile_sensor(system, in, options);
        const ImageView<const float> view = scene.view();
        const double rms = rms_between(tiled(plan, scene, 2.0), all.run(std::span(&view, 1), 2.0, 1).front());
        EXPECT_LE(rms / options.scene->std, plan.report().predicted_error + all.predicted_error)
            << kBorderNames[static_cast<std::size_t>(border)] << " " << tolerance << " " << plan.report().reason;
        EXPECT_LE(plan.report().predicted_error, tolerance);
      }
  EXPECT_GE(split, 8);
}

}  // namespace
}  // namespace mtf::test
