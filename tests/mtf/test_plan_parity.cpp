// SPDX-License-Identifier: Apache-2.0
// Mirrored scenes and OTFs that are not even: cosines and sines of image size, against the canvas of four images.
#include "tests/mtf/plan_support.h"

namespace mtf::test {
namespace {

System<double> slanted() { return with(bare(), {Component<double>::make("diffraction"), motion(30.0, 35.0)}); }
System<double> across() { return with(bare(), {Component<double>::make("diffraction"), rc(25.0, 0)}); }
System<double> down() { return with(bare(), {Component<double>::make("diffraction"), rc(25.0, 1)}); }
System<double> any() {
  return with(bare(), {Component<double>::make("diffraction"), rc(25.0, 0), rc(40.0, 1), motion(20.0, -50.0)});
}

bool has_sines(const Plan& plan) {
  return plan.report().axes[0].find("sine ") != std::string::npos ||
         plan.report().axes[1].find("-sine ") != std::string::npos;
}

// Ramps and points near all four edges: what a wrong sign or fold of a sine does is largest there.
Image edgy(std::int64_t width, std::int64_t height) {
  return image_of(width, height, [&](auto x, auto y) {
    const double ramp = static_cast<double>(x) / static_cast<double>(width) -
                        0.6 * static_cast<double>(y) / static_cast<double>(height);
    return ramp + (x == 1 && y % 3 == 0 ? 2.0 : 0.0) + (y == height - 2 ? 1.0 : 0.0) +
           ((x * 5 + y * 7) % 11 == 0 ? 1.0 : 0.0);
  });
}

TEST(PlanParity, every_parity_keeps_its_promise_on_every_grid) {
  int sines = 0;
  for (const System<double>& system : {slanted(), across(), down(), any()})
    for (const auto& [width, height] : {std::pair{48, 36}, {37, 53}, {60, 1}, {2, 30}})
      for (const auto& [ratio_x, ratio_y] : {std::pair{1.0, 1.0}, {2.0, 2.0}, {4.0, 1.0}, {2.3, 1.0}, {1.0, 1.7}}) {
        if (width < ratio_x || height < ratio_y) continue;
        const SampleGrid in = scene_grid(system, width, height, ratio_x, ratio_y), out = detector_grid(system, in);
        const Image scene = edgy(width, height);
        const auto expected = reference_image(scene, in, out, otf_of(system, Stage::presample), Border::reflect, 0.0);
        PlanOptions options = options_for(scene, Border::reflect, 1e-4);
        for (const Method method : {Method::fft_float, Method::fft_double}) {
          options.method = method;
          const Plan plan = compile(system, in, out, options);
          const double rms = rms_distance(run(plan, scene), expected) / options.scene->std;
          EXPECT_LE(rms, plan.report().predicted.total())
              << width << "x" << height << ", ratio " << ratio_x << " x " << ratio_y << "\n"
              << plan.explain();
          sines += has_sines(plan) ? 1 : 0;
        }
      }
  EXPECT_GT(sines, 90);
}

TEST(PlanParity, frequencies_beyond_the_cutoff_are_left_out) {
  System<double> system = any();
  system.add(Stage::presample, gaussian(25.0));
  for (const double ratio : {1.0, 2.0}) {
    const SampleGrid in = scene_grid(system, 90, 80, ratio, ratio), out = detector_grid(system, in);
    const Image scene = edgy(90, 80);
    PlanOptions options = options_for(scene, Border::reflect, 1e-3);
    options.method = Method::fft_cut;
    const Plan plan = compile(system, in, out, options);
    ASSERT_TRUE(has_sines(plan)) << plan.explain();
    EXPECT_LT(plan.report().kept[0], plan.report().available[0]);
    EXPECT_LT(plan.report().kept[1], plan.report().available[1]);
    const auto expected = reference_image(scene, in, out, otf_of(system, Stage::presample), Border::reflect, 0.0);
    EXPECT_LE(rms_distance(run(plan, scene), expected) / options.scene->std, plan.report().predicted.total());
  }
}

// A filter of one tap moves the mirrored scene: the result is known without any transform. All four parities.
TEST(PlanParity, a_tap_off_the_middle_moves_the_mirrored_scene) {
  const auto mirrored = [](std::int64_t i, std::int64_t n) { return i < 0 ? -1 - i : i >= n ? 2 * n - 1 - i : i; };
  for (const auto& [right, below] : {std::pair{2, 0}, {0, -3}, {1, 2}, {-3, 1}}) {
    Taps<double> taps(7, std::vector<double>(7, 0.0));
    taps[static_cast<std::size_t>(3 + below)][static_cast<std::size_t>(3 + right)] = 1.0;
    System<double> system = bare();
    system.add(Stage::postsample, fir(taps));
    const SampleGrid grid{30, 21, 15.0, 12.0};  // smaller than what a canvas is shortened for
    const Image scene = edgy(30, 21);
    PlanOptions options = options_for(scene, Border::reflect, 1e-5);
    options.method = Method::fft_double;
    constexpr std::array stages{Stage::postsample};
    const Plan plan = compile_post(system, grid, stages, options);
    EXPECT_TRUE(has_sines(plan)) << plan.explain();
    const Image moved = run(plan, scene);
    for (std::int64_t y = 0; y < grid.height; ++y)
      for (std::int64_t x = 0; x < grid.width; ++x)
        ASSERT_NEAR(moved.at(x, y), scene.at(mirrored(x - right, grid.width), mirrored(y - below, grid.height)), 1e-6);
  }
}

// Frames of a turning motion share transforms; along an axis it is even, and the frames beside are not.
TEST(PlanParity, a_motion_that_turns_gives_the_plans_made_afresh) {
  const SampleGrid in = scene_grid(bare(), 96, 80, 2.0, 1.0), out = detector_grid(bare(), in);
  const Image scene = edgy(96, 80);
  PlanOptions options = options_for(scene, Border::reflect, 1e-5);
  options.method = Method::fft_float;
  const auto at = [](double degrees) {
    return with(bare(), {Component<double>::make("diffraction"), motion(25.0, degrees)});
  };
  Plan plan = compile(at(-3.0), in, out, options);
  for (const double degrees : {-2.0, 0.0, 2.0, 45.0, 88.0, 90.0, 92.0, 135.0}) {
    plan = plan.with(at(degrees));
    EXPECT_TRUE(same_bits(run(plan, scene), run(compile(at(degrees), in, out, options), scene))) << degrees;
    const auto expected = reference_image(scene, in, out, otf_of(at(degrees), Stage::presample), Border::reflect, 0.0);
    EXPECT_LE(rms_distance(run(plan, scene), expected) / options.scene->std, plan.report().predicted.total());
  }
}

TEST(PlanParity, rows_at_mirrored_frequencies_are_those_of_the_grid_turned_over) {
  const System<double> real = slanted(), complex = any();
  constexpr std::array stages{Stage::presample};
  const std::vector<double> fx{0.0, 3.0, 11.0, 29.0}, fy{0.0, 5.0, 17.0, 31.0}, turned{-0.0, -5.0, -17.0, -31.0};
  for (const double table_share : {0.0, 1e-7}) {
    const SamplerOptions options{.fx_max = 40.0, .fy_max = 40.0, .table_share = table_share};
    const FactoredOtf a(real, stages, {}, options), b(complex, stages, {}, options);
    const FactoredOtf::Grid up(a, fx, fy), over(a, fx, turned), complex_up(b, fx, fy), complex_over(b, fx, turned);
    for (std::size_t j = 0; j < fy.size(); ++j) {
      std::vector<float> first(4), second(4), expected(4);
      up.real_rows(j, std::span(first), std::span(second));
      up.real_row(j, std::span(expected));
      EXPECT_EQ(first, expected);
      over.real_row(j, std::span(expected));
      EXPECT_EQ(second, expected);
      std::vector<Complex<double>> mirrored(4), direct(4);
      complex_up.complex_row(j, std::span(mirrored), true);
      complex_over.complex_row(j, std::span(direct));
      for (std::size_t i = 0; i < fx.size(); ++i) {
        EXPECT_NEAR(mirrored[i].re, direct[i].re, 1e-15);
        EXPECT_NEAR(mirrored[i].im, direct[i].im, 1e-15);
      }
    }
  }
}

}  // namespace
}  // namespace mtf::test
