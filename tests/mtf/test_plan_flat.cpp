// SPDX-License-Identifier: Apache-2.0
// Flat in, flat out: the gain of the mean is H(0) for every size, ratio and border.
#include "tests/mtf/plan_support.h"

namespace mtf::test {
namespace {

struct Size {
  std::int64_t width, height;
};
constexpr std::array kSizes{Size{1, 1},   Size{1, 7},    Size{13, 1},   Size{2, 3},  Size{127, 131},
                            Size{64, 32}, Size{4097, 3}, Size{3, 4097}, Size{31, 1}, Size{1, 1024}};

System<double> optics() { return with(bare(), {Component<double>::make("diffraction"), footprint(12.0), rc(40.0, 0)}); }

TEST(PlanFlat, scene_comes_out_flat_for_every_size_ratio_and_border) {
  for (const Size& size : kSizes)
    for (const double ratio : {1.0, 2.0, 3.7, M_PI, 0.6})
      for (const Border border : kBorders) {
        const System<double> system = optics();
        const SampleGrid in =
            scene_grid(system, size.width, size.height, std::min(ratio, static_cast<double>(size.width)),
                       std::min(ratio, static_cast<double>(size.height)));
        PlanOptions options;
        options.border = border;
        const Plan plan = compile(system, in, detector_grid(system, in), options);
        EXPECT_DOUBLE_EQ(plan.dc(), 1.0);
        for (const float value : {0.1F, -7.3e6F, 1e-38F}) {
          const Image scene = image_of(size.width, size.height, [&](auto, auto) { return value; });
          const Image image = run(plan, scene, static_cast<double>(value));
          for (std::int64_t i = 0; i < image.size(); ++i) ASSERT_EQ(image.data()[i], value) << plan.explain();
        }
      }
}

// The border value of a config is a double and hardly ever equals the float of the scene: the engine runs, and the
// image stays flat.
TEST(PlanFlat, scene_with_its_own_level_as_a_double_border_is_flat_within_1e6) {
  for (const Size& size : kSizes)
    for (const double ratio : {1.0, 2.0, 3.7}) {
      const System<double> system = optics();
      const SampleGrid in =
          scene_grid(system, size.width, size.height, std::min(ratio, static_cast<double>(size.width)),
                     std::min(ratio, static_cast<double>(size.height)));
      PlanOptions options;
      options.border = Border::constant;
      const Plan plan = compile(system, in, detector_grid(system, in), options);
      const Image image = run(plan, image_of(size.width, size.height, [](auto, auto) { return 0.1; }), 0.1);
      for (std::int64_t i = 0; i < image.size(); ++i) ASSERT_NEAR(image.data()[i], 0.1, 1e-7);
    }
}

TEST(PlanFlat, gain_of_a_digital_filter_is_its_sum) {
  for (const auto& [taps, gain] : {std::pair<Taps<double>, double>{{{0.25, 1.5, -0.25}}, 1.5},
                                   std::pair<Taps<double>, double>{{{0, -1, 0}, {-1, 4, -1}, {0, -1, 0}}, 0.0}}) {
    System<double> system = bare();
    system.add(Stage::postsample, fir(taps));
    constexpr std::array stages{Stage::readout, Stage::postsample};
    for (const Size& size : kSizes)
      for (const Border border : kBorders) {
        PlanOptions options;
        options.border = border;
        const Plan plan = compile_post(system, {size.width, size.height, 15.0, 12.0}, stages, options);
        EXPECT_NEAR(plan.dc(), gain, 1e-14);
        const Image image = run(plan, image_of(size.width, size.height, [](auto, auto) { return 3.0; }), 3.0);
        for (std::int64_t i = 0; i < image.size(); ++i) ASSERT_NEAR(image.data()[i], 3.0 * gain, 3e-6);
      }
  }
}

// The mean of a scene with contrast obeys the same gain, however far it stands above the contrast.
TEST(PlanFlat, mean_is_carried_apart_even_when_the_filter_is_almost_one) {
  System<double> system = bare();
  system.add(Stage::postsample, fir({{0.0, 1.0 + 2e-6, 0.0}}));
  constexpr std::array stages{Stage::postsample};
  const Image scene = image_of(32, 32, [](auto x, auto y) { return 1000.0 + ((x + y) % 2 == 0 ? 0.05 : -0.05); });
  const Plan plan = compile_post(system, {32, 32, 15.0, 12.0}, stages, options_for(scene, Border::periodic, 0.01));
  const Image image = run(plan, scene);
  double sum = 0.0;
  for (std::int64_t i = 0; i < image.size(); ++i) sum += image.data()[i];
  EXPECT_NEAR(sum / 1024.0, 1000.0 * (1.0 + 2e-6), 2e-4) << plan.explain();
}

}  // namespace
}  // namespace mtf::test
