// SPDX-License-Identifier: Apache-2.0
// Extremes of scale, contrast, size and request: finite and within the promise, or refused by name.
#include <limits>

#include "tests/expect_error.h"
#include "tests/mtf/plan_support.h"

namespace mtf::test {
namespace {

System<double> optics() { return with(bare(), {Component<double>::make("diffraction"), footprint(12.0), rc(40.0, 0)}); }

/// Compiles for the scene (at the tolerance that a refusal names, if there is one), runs, and compares.
void expect_kept(const System<double>& system, const SampleGrid& in, const Image& scene, Border border,
                 double tolerance, double border_value) {
  const SampleGrid out = detector_grid(system, in);
  PlanOptions options = options_for(scene, border, tolerance, border_value);
  ASSERT_TRUE(options.scene);
  try {
    compile(system, in, out, options);
  } catch (const UsageError& refusal) {
    const std::string text = refusal.what();
    if (text.find("no tolerance") != std::string::npos) {
      // True only where the values themselves are coarse against the contrast.
      EXPECT_GT(std::max(options.scene->largest, std::abs(border_value)) / options.scene->std, 1e5) << text;
      return;
    }
    options.tolerance = named_tolerance(text);
    ASSERT_GT(options.tolerance, tolerance) << text;
  }
  const Plan plan = compile(system, in, out, options);
  const Image image = run(plan, scene, border_value);
  ASSERT_TRUE(all_finite(image)) << plan.explain();
  const double rms =
      rms_distance(image, reference_image(scene, in, out, otf_of(system, Stage::presample), border, border_value));
  EXPECT_LE(rms / options.scene->std, plan.report().predicted.total()) << plan.explain();
}

TEST(PlanExtremes, scale_of_the_values_does_not_matter) {
  for (const double scale : {1e-44, 1e-40, 1e-30, 1e30, 5e37})
    for (const Border border : kBorders) {
      Image scene = random_image(20, 18, 4, 1.0);
      for (std::int64_t i = 0; i < scene.size(); ++i)
        scene.data()[i] = static_cast<float>(std::clamp<double>(scene.data()[i], -3.0, 3.0) * scale);
      expect_kept(optics(), scene_grid(optics(), 20, 18, 2.0, 3.7), scene, border, 1e-4, 1.5 * scale);
    }
}

// Changes by more than the largest float, between values that are floats; blurred, nothing lies beyond them.
TEST(PlanExtremes, the_largest_values_there_are) {
  const System<double> system = with(bare(15.0, 15.0), {gaussian(27.0)});
  const Image scene =
      image_of(64, 48, [](std::int64_t x, std::int64_t y) { return (x / 8 + y / 12) % 2 == 0 ? 3.3e38 : -3.3e38; });
  const SampleGrid in = scene_grid(system, 64, 48, 1.0, 1.0);
  for (const Method method : {Method::separable, Method::fft_float, Method::fft_double}) {
    PlanOptions options = options_for(scene, Border::reflect, 1e-3);
    options.method = method;
    const Image image = run(compile(system, in, in, options), scene);
    EXPECT_TRUE(all_finite(image)) << static_cast<int>(method);
  }
}

TEST(PlanExtremes, small_contrast_on_a_large_mean) {
  for (const double mean : {0.0, 1.0, 1e6, -1e6})
    for (const double contrast : {1e-6, 1e-3})
      for (const Border border : kBorders) {
        const double std = contrast * std::max(std::abs(mean), 1.0);
        const Image scene = random_image(24, 20, 9, mean, std);
        expect_kept(optics(), scene_grid(optics(), 24, 20, 2.0, 2.0), scene, border, 1e-3, mean);
      }
}

TEST(PlanExtremes, border_level_far_from_the_scene) {
  for (const double border_value : {0.0, 1e3, 1e6, -1e6})
    for (const std::int64_t width : {8, 40}) {
      const Image scene = random_image(width, 33, 6, 300.0, 1.0);
      expect_kept(optics(), scene_grid(optics(), width, 33, 2.0, 3.7), scene, Border::constant, 1e-2, border_value);
      const auto soft = with(bare(), {jitter(0.01), footprint(0.02), test::gaussian(4.0)});
      expect_kept(soft, scene_grid(soft, width, 33, 2.0, 1.0), scene, Border::constant, 1e-2, border_value);
    }
}

TEST(PlanExtremes, systems_that_pass_next_to_nothing_or_everything) {
  const Image scene = random_image(32, 24, 2, 5.0);
  System<double> slow = bare();
  slow.optics.f_number = 5000.0;  // cutoff 0.05 cy/mm, far below the first frequency of the scene
  slow.add(Stage::presample, Component<double>::make("diffraction"));
  for (const Border border : kBorders) {
    for (const auto& system : {slow, with(bare(), {jitter(1000.0)}), with(bare(), {jitter(1000.0 * 15.0)}),
                               with(bare(), {rc(1e-6, 0)}), with(bare(), {motion(1e6, 30.0)}),
                               with(bare(), {test::gaussian(0.0)}), with(bare(), {jitter(1e9), rc(1e9, 1)})})
      expect_kept(system, scene_grid(system, 32, 24, 2.0, 3.7), scene, border, 1e-4, 5.0);
  }
}

TEST(PlanExtremes, ratios_far_from_one) {
  for (const Border border : kBorders) {
    const Image coarse = random_image(6, 9, 2);
    expect_kept(optics(), scene_grid(optics(), 6, 9, 0.3, 0.3), coarse, border, 1e-4, 0.0);
    const Image fine = random_image(100, 52, 2);
    expect_kept(optics(), scene_grid(optics(), 100, 52, 50.0, 50.0), fine, border, 1e-4, 0.0);
    expect_kept(optics(), scene_grid(optics(), 100, 52, 33.3, 51.7), fine, border, 1e-4, 0.0);
  }
}

TEST(PlanExtremes, format_much_smaller_than_the_scene) {
  System<double> system = with(bare(), {jitter(0.4), Component<double>::make("diffraction"), motion(9.0, 30.0)});
  system.frame.columns = 2;
  system.frame.rows = 3;
  // All contrast stands in the corner that is kept.
  const Image scene = image_of(80, 64, [](auto x, auto y) { return x == 1 && y == 2 ? 1.0 : 0.0; });
  for (const Border border : kBorders)
    for (const double tolerance : {1e-1, 1e-2, 1e-3})
      expect_kept(system, scene_grid(system, 80, 64, 1.0, 1.0), scene, border, tolerance, 0.0);
}

// The same sensor with every length scaled: the same picture.
TEST(PlanExtremes, tiny_and_huge_sample_steps) {
  const Image scene = random_image(30, 24, 12, 1.0);
  Image first;
  for (const double unit : {1.0, 1e-6, 1e4}) {
    System<double> system = bare(15.0 * unit, 12.0 * unit);
    system.add(Stage::presample, test::gaussian(7.0 * unit));
    auto lens =
        std::make_shared<const Curve>(make_curve("lens.csv", *find_unit("cy/px"), {0.1, 0.5, 1.5}, {0.9, 0.5, 0}));
    auto table = Component<double>::make("curve");
    *std::get<CurveSum<double>*>(field(table, "file").value) = lens;
    choose(table, "axis", 1);
    system.add(Stage::presample, table);
    const SampleGrid in = scene_grid(system, 30, 24, 2.0, 3.0);
    const Plan plan = compile(system, in, detector_grid(system, in), options_for(scene, Border::reflect, 1e-4));
    const Image image = run(plan, scene);
    ASSERT_TRUE(all_finite(image)) << unit;
    if (first.size() == 0) first = image.clone();
    for (std::int64_t i = 0; i < image.size(); ++i) ASSERT_NEAR(image.data()[i], first.data()[i], 1e-4) << unit;
  }
}

TEST(PlanExtremes, radial_table_at_extreme_pitches) {
  for (const double unit : {1e-6, 1e4}) {
    System<double> system = bare(15.0 * unit, 15.0 * unit);
    auto table = Component<double>::make("curve");
    *std::get<CurveSum<double>*>(field(table, "file").value) =
        std::make_shared<const Curve>(make_curve("lens.csv", *find_unit("cy/px"), {0.1, 0.5, 1.5}, {0.9, 0.5, 0.0}));
    system.add(Stage::presample, table);
    const Image scene = random_image(16, 12, 12, 1.0);
    expect_kept(system, scene_grid(system, 16, 12, 2.0, 1.0), scene, Border::reflect, 1e-4, 0.0);
  }
}

TEST(PlanBadInput, pixels_that_are_not_finite_are_counted_and_placed) {
  const System<double> system = optics();
  const SampleGrid in{20, 10, 15.0, 12.0};
  const Plan plan = compile(system, in, detector_grid(system, in), {});
  for (const float bad : {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity(),
                          -std::numeric_limits<float>::infinity()})
    for (const int count : {1, 3}) {
      Image scene = random_image(20, 10, 1);
      for (int i = 0; i < count; ++i) scene.at(17 - i, 4 + i) = bad;
      Image out(20, 10);
      expect_refused<mtf::RuntimeError>({std::to_string(count), "column 17, row 4"},
                                        [&] { plan.run(scene.view(), out.view()); });
    }
}

TEST(PlanBadInput, border_level_that_is_not_finite_is_refused) {
  const SampleGrid in{20, 10, 15.0, 12.0};
  PlanOptions options;
  options.border = Border::constant;
  const Plan plan = compile(optics(), in, detector_grid(optics(), in), options);
  const Image scene = random_image(20, 10, 1);
  Image out(20, 10);
  for (const double border_value : {std::nan(""), HUGE_VAL})
    EXPECT_THROW(plan.run(scene.view(), out.view(), border_value), UsageError) << border_value;
}

TEST(PlanBadInput, sizes_that_differ_are_refused) {
  const SampleGrid in{20, 10, 15.0, 12.0};
  const Plan plan = compile(optics(), in, detector_grid(optics(), in), {});
  Image good(20, 10), bad(10, 20), flat = image_of(20, 11, [](auto, auto) { return 1.0; });
  const Image scene = random_image(20, 10, 1);
  EXPECT_THROW(plan.run(bad.view(), good.view()), UsageError);
  EXPECT_THROW(plan.run(flat.view(), good.view()), UsageError);
  EXPECT_THROW(plan.run(scene.view(), bad.view()), UsageError);
  const std::array<ImageView<const float>, 2> planes{scene.view(), scene.view()};
  const std::array<ImageView<float>, 1> outs{good.view()};
  EXPECT_THROW(plan.run(planes, outs), UsageError);
}

TEST(PlanBadInput, grids_that_cannot_be_are_refused) {
  const System<double> system = optics();
  for (const SampleGrid& in : {SampleGrid{0, 10, 15.0, 12.0},
                               {10, -1, 15.0, 12.0},
                               {10, 10, 0.0, 12.0},
                               {10, 10, 15.0, -1.0},
                               {10, 10, std::nan(""), 12.0},
                               {10, 10, HUGE_VAL, 12.0},
                               {std::int64_t{1} << 40, 10, 15.0, 12.0},
                               {10, std::int64_t{1} << 62, 15.0, 12.0}}) {
    EXPECT_THROW(detector_grid(system, in), UsageError);
    EXPECT_THROW(compile(system, in, {4, 4, 15.0, 12.0}, {}), UsageError);
    EXPECT_THROW(compile(system, {4, 4, 15.0, 12.0}, in, {}), UsageError);
  }
  EXPECT_THROW(detector_grid(system, {3, 100, 4.9, 12.0}), UsageError) << "smaller than one pixel";
  // More bytes than any machine has: refused before anything is allocated.
  const std::int64_t huge = std::int64_t{1} << 28;
  EXPECT_THROW(compile(system, {huge, huge, 15.0, 12.0}, {4, 4, 15.0, 12.0}, {}), UsageError);
}

TEST(PlanBadInput, tolerances_outside_0_1_are_refused) {
  const SampleGrid in{20, 10, 15.0, 12.0};
  for (const double tolerance : {0.0, -1e-3, 1.0, 2.0, std::nan(""), HUGE_VAL}) {
    PlanOptions options;
    options.tolerance = tolerance;
    EXPECT_THROW(compile(optics(), in, detector_grid(optics(), in), options), UsageError) << tolerance;
  }
  const Image scene = random_image(20, 10, 1);
  PlanOptions options = options_for(scene, Border::reflect, 1e-20);
  try {
    compile(optics(), in, detector_grid(optics(), in), options);
    FAIL() << "accepted";
  } catch (const UsageError& refusal) {
    options.tolerance = named_tolerance(refusal.what());
    EXPECT_LT(options.tolerance, 1e-4);
    EXPECT_NO_THROW(compile(optics(), in, detector_grid(optics(), in), options));
  }
}

}  // namespace
}  // namespace mtf::test
