// SPDX-License-Identifier: Apache-2.0
// Shorter canvases: chosen where the point spread ends soon, and their wrap-around stays below its bound.
#include "mtf/plan/padding.h"

#include "tests/mtf/plan_support.h"

namespace mtf::test {
namespace {

// Edges at both ends of the image differ, so that what wraps around is seen.
Image uneven_scene(std::int64_t width, std::int64_t height) {
  return image_of(width, height, [&](auto x, auto y) {
    return static_cast<double>(x) / static_cast<double>(width) -
           0.7 * static_cast<double>(y) / static_cast<double>(height) + (x < 2 ? 1.0 : 0.0) +
           ((x * 7 + y * 3) % 5 == 0 ? 0.2 : 0.0);
  });
}

struct Case {
  std::int64_t width, height;
  double ratio_x, ratio_y;
};

TEST(Padding, canvas_is_shortened_for_fast_decays_and_the_bound_holds) {
  int shortened = 0;
  for (const auto& system : {with(bare(), {test::gaussian(9.0)}), with(bare(), {test::gaussian(9.0), rc(80.0, 0)}),
                             with(bare(), {test::gaussian(8.0), rc(90.0, 1), motion(12.0, 30.0)})})
    for (const Case& c :
         {Case{64, 48, 1.0, 2.0}, {96, 72, 2.0, 2.0}, {75, 80, 3.0, 4.0}, {80, 66, 3.7, M_PI}, {70, 40, 2.5, 1.0}})
      for (const Border border : {Border::replicate, Border::constant, Border::reflect})
        for (const double tolerance : {1e-2, 1e-3, 1e-4}) {
          const SampleGrid in = scene_grid(system, c.width, c.height, c.ratio_x, c.ratio_y);
          const SampleGrid out = detector_grid(system, in);
          const Image scene = uneven_scene(c.width, c.height);
          const double level = -1.0;
          const PlanOptions options = options_for(scene, border, tolerance, level);
          const Plan plan = compile(system, in, out, options);
          const PlanReport& report = plan.report();
          if (report.predicted.wrap == 0.0) continue;
          EXPECT_TRUE(report.size[0] < canvas_length(border, c.width) ||
                      report.size[1] < canvas_length(border, c.height));
          if ((shortened++ % 3) != 0) continue;  // the slow sums for a third of them
          const auto expected = reference_image(scene, in, out, otf_of(system, Stage::presample), border, level);
          const double rms = rms_distance(run(plan, scene, level), expected) / options.scene->std;
          EXPECT_LE(rms, report.predicted.total()) << plan.explain();
          EXPECT_LE(report.predicted.wrap, 0.25 * tolerance * (1.0 + 1e-9));
        }
  EXPECT_GT(shortened, 20);
}

// Replicate and constant are shortened, and reflect with a phase along both axes, at a tolerance of every day.
TEST(Padding, every_padded_border_is_shortened_for_a_large_image) {
  const System<double> system = with(bare(), {test::gaussian(15.0), rc(80.0, 0), rc(80.0, 1)});
  const SampleGrid in = scene_grid(system, 640, 512, 2.0, 2.0);
  for (const Border border : {Border::replicate, Border::constant, Border::reflect}) {
    PlanOptions options;
    options.border = border;
    options.method = Method::fft_float;  // taps need no canvas
    const PlanReport report = compile(system, in, detector_grid(system, in), options).report();
    EXPECT_LT(static_cast<double>(report.size[0]), 1.35 * 640.0) << report.axes[0];
    EXPECT_LT(static_cast<double>(report.size[1]), 1.35 * 512.0) << report.axes[1];
    EXPECT_GT(report.predicted.wrap, 0.0);
  }
}

// An OTF of 1 has a point for a point spread only at the samples; half-way between them it rings across the image.
TEST(Padding, outputs_between_samples_keep_the_whole_canvas_when_the_otf_does_not_end) {
  const System<double> system = bare();
  for (const double ratio : {2.0, 3.7}) {
    const SampleGrid in = scene_grid(system, 64, 60, ratio, ratio);
    const SampleGrid out = detector_grid(system, in);
    const Image scene = uneven_scene(64, 60);
    for (const Border border : {Border::replicate, Border::constant}) {
      const Plan plan = compile(system, in, out, options_for(scene, border, 1e-3));
      EXPECT_EQ(plan.report().size[0], 192) << plan.explain();
      const auto one = [](double, double) { return std::complex<double>(1.0); };
      const double rms = rms_distance(run(plan, scene), reference_image(scene, in, out, one, border));
      EXPECT_LE(rms / statistics(scene.view()).std, plan.report().predicted.total());
    }
  }
}

TEST(Padding, chosen_lengths_are_smooth_and_within_a_tenth_of_the_least) {
  const System<double> system = with(bare(), {test::gaussian(15.0)});
  constexpr std::array stages{Stage::presample};
  for (const std::int64_t n : {33, 100, 641, 1021}) {
    const FactoredOtf sampler(system, stages, {}, {.fx_max = 66.7, .fy_max = 83.4, .table_share = 1e-7});
    const CanvasRequest request{Axis::x, Border::replicate, n, 7.5, 83.4, 15.0, 2.0, 1e-4};
    const CanvasLength canvas = choose_canvas(sampler, request);
    EXPECT_TRUE(is_smooth(canvas.length)) << canvas.length;
    EXPECT_GT(canvas.length, n);
    EXPECT_LE(canvas.bound, 1e-4);
    // Six sigma, of two samples each, to each side are more than enough.
    EXPECT_LE(static_cast<double>(canvas.length), 1.1 * static_cast<double>(next_smooth(n + 24)));
  }
}

// Two images 1e9 pixels apart: on a canvas whose length divides that, both lie on the middle.
TEST(Padding, an_echo_at_a_multiple_of_the_canvas_is_found) {
  auto filter = Component<double>::make("birefringent_filter");
  test::set(filter, "separation", 1e9, "px");
  const System<double> system = with(bare(), {filter});
  constexpr std::array stages{Stage::presample};
  const FactoredOtf sampler(system, stages, {}, {.fx_max = 66.7, .fy_max = 83.4, .table_share = 1e-7});
  for (const std::int64_t n : {40, 41, 64, 100}) {
    const CanvasRequest request{Axis::y, Border::replicate, n, 6.0, 66.7, 15.0, 2.0, 1e-4};
    EXPECT_EQ(choose_canvas(sampler, request).length, canvas_length(Border::replicate, n)) << n;
  }
}

TEST(Padding, periodic_small_and_tight_requests_get_the_defined_canvas) {
  const System<double> system = with(bare(), {test::gaussian(6.0)});
  constexpr std::array stages{Stage::presample};
  const FactoredOtf sampler(system, stages, {}, {.fx_max = 66.7, .fy_max = 83.4, .table_share = 1e-7});
  CanvasRequest request{Axis::x, Border::periodic, 101, 7.5, 83.4, 15.0, 2.0, 1e-4};
  EXPECT_EQ(choose_canvas(sampler, request).length, 101);
  request.border = Border::replicate;
  request.samples = 7;
  EXPECT_EQ(choose_canvas(sampler, request).length, 21);
  request.samples = 101;
  request.budget = 0.0;
  EXPECT_EQ(choose_canvas(sampler, request).length, 303);
  EXPECT_EQ(choose_canvas(sampler, request).bound, 0.0);
}

}  // namespace
}  // namespace mtf::test
