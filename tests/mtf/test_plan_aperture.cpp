// SPDX-License-Identifier: Apache-2.0
// The scene's own aperture: samples that were averaged by a renderer give the image of point samples.
#include <functional>
#include <random>

#include "mtf/math/special.h"
#include "tests/expect_error.h"
#include "tests/mtf/plan_support.h"

namespace mtf::test {
namespace {

constexpr std::int64_t kWidth = 60, kHeight = 48;

struct Wave {
  std::int64_t kx, ky;
  double amplitude, phase;
};

std::vector<Wave> waves() {
  std::mt19937 generator(3);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  std::vector<Wave> list;
  for (int i = 0; i < 25; ++i)
    list.push_back({static_cast<std::int64_t>(generator() % 24), static_cast<std::int64_t>(generator() % 37) - 18,
                    unit(generator), 2.0 * M_PI * unit(generator)});
  return list;
}

// Sum of the waves, each by the aperture's MTF at its frequency in cycles/mm.
Image scene_of(const SampleGrid& grid, const std::function<double(double, double)>& mtf) {
  const auto list = waves();
  return image_of(grid.width, grid.height, [&](auto x, auto y) {
    double v = 5.0;
    for (const Wave& w : list) {
      const double u = static_cast<double>(w.kx) / static_cast<double>(grid.width);
      const double t = static_cast<double>(w.ky) / static_cast<double>(grid.height);
      v += w.amplitude * mtf(1e3 * u / grid.step_x_um, 1e3 * t / grid.step_y_um) *
           std::cos(2.0 * M_PI * (u * (static_cast<double>(x) + 0.5) + t * (static_cast<double>(y) + 0.5)) + w.phase);
    }
    return v;
  });
}

void expect_same_image(const SceneAperture& aperture, const std::function<double(double, double)>& mtf, double ratio) {
  const System<double> system = with(bare(), {Component<double>::make("diffraction"), footprint(12.0), rc(60.0, 0)});
  const SampleGrid in = scene_grid(system, kWidth, kHeight, ratio, ratio);
  const SampleGrid out = detector_grid(system, in);
  const Image point = scene_of(in, [](double, double) { return 1.0; });
  const Image blurred = scene_of(in, mtf);
  PlanOptions options = options_for(point, Border::periodic, 1e-4);
  const Image expected = run(compile(system, in, out, options), point);
  options = options_for(blurred, Border::periodic, 2e-5);
  options.aperture = aperture;
  const Plan plan = compile(system, in, out, options);
  EXPECT_TRUE(plan.report().notes.empty()) << plan.explain();
  const Image image = run(plan, blurred);
  const double std = statistics(point.view()).std;
  for (std::int64_t i = 0; i < image.size(); ++i)
    ASSERT_NEAR(image.data()[i], expected.data()[i], 1e-4 * std) << "ratio " << ratio << "\n" << plan.explain();
}

SceneAperture sized(SceneAperture::Kind kind, double x_um, double y_um) {
  SceneAperture aperture;
  aperture.kind = kind;
  aperture.size = {{x_um, find_unit("um")}, {y_um, find_unit("um")}, true};
  return aperture;
}

TEST(PlanAperture, box_averaged_scene_gives_the_image_of_the_point_sampled_one) {
  for (const double ratio : {1.0, 2.0, 3.7, 4.0}) {
    const double wx = 15.0 / ratio, wy = 12.0 / ratio;
    expect_same_image(
        sized(SceneAperture::Kind::box, wx, wy),
        [&](double fx, double fy) { return sinc(1e-3 * wx * fx).value * sinc(1e-3 * wy * fy).value; }, ratio);
  }
}

TEST(PlanAperture, gaussian_blur_of_the_scene_is_divided_out) {
  for (const double ratio : {2.0, M_PI}) {
    const double sx = 0.3 * 15.0 / ratio, sy = 0.25 * 12.0 / ratio;
    expect_same_image(
        sized(SceneAperture::Kind::gaussian, sx, sy),
        [&](double fx, double fy) {
          return std::exp(-2.0 * M_PI * M_PI * 1e-6 * (sx * sx * fx * fx + sy * sy * fy * fy));
        },
        ratio);
  }
}

TEST(PlanAperture, tabulated_blur_of_the_scene_is_divided_out) {
  SceneAperture aperture;
  aperture.kind = SceneAperture::Kind::curve;
  aperture.curve = std::make_shared<const Curve>(
      make_curve("aperture.csv", *find_unit("cy/mm"), {20.0, 60.0, 120.0, 400.0}, {0.97, 0.8, 0.6, 0.2}));
  expect_same_image(
      aperture, [&](double fx, double fy) { return evaluate(*aperture.curve, std::hypot(fx, fy)).value; }, 2.0);
}

// Beyond the limit g the correction of one axis is g A instead of 1/A (g = sqrt of the limit for both axes).
TEST(PlanAperture, gain_stays_below_the_limit_and_the_report_says_so) {
  const System<double> system = bare();
  const SampleGrid in = scene_grid(system, 64, 4, 1.0, 1.0);
  PlanOptions options;
  options.border = Border::periodic;
  options.aperture = sized(SceneAperture::Kind::gaussian, 12.0, 0.0);
  options.aperture.gain_limit = 9.0;
  const Plan plan = compile(system, in, detector_grid(system, in), options);
  ASSERT_EQ(plan.report().notes.size(), 1U);
  expect_says(plan.report().notes.front(), {"9"});
  double highest = 0.0;
  for (std::int64_t k = 1; k < 32; ++k) {
    const Image image = run(
        plan, image_of(64, 4, [&](auto x, auto) { return std::cos(2.0 * M_PI * static_cast<double>(k * x) / 64.0); }));
    double seen = 0.0;
    for (std::int64_t x = 0; x < 64; ++x)
      seen += image.at(x, 0) * std::cos(2.0 * M_PI * static_cast<double>(k * x) / 64.0) / 32.0;
    const double a = std::exp(-2.0 * std::pow(M_PI * 12.0 / 15.0 * static_cast<double>(k) / 64.0, 2));
    EXPECT_NEAR(seen, a >= 1.0 / 3.0 ? 1.0 / a : 9.0 * a, 3e-4) << k;
    highest = std::max(highest, seen);
  }
  EXPECT_LE(highest, 3.0 + 1e-3);
  EXPECT_GT(highest, 2.5);
}

// A box of two samples has its zero at the scene's Nyquist frequency: limited before, not at, the last frequency.
TEST(PlanAperture, limit_that_is_met_inside_the_band_only_is_reported_too) {
  const System<double> system = bare();
  const SampleGrid in = scene_grid(system, 64, 64, 1.0, 1.0);
  PlanOptions options;
  options.aperture = sized(SceneAperture::Kind::box, 30.0, 24.0);
  EXPECT_FALSE(compile(system, in, detector_grid(system, in), options).report().notes.empty());
  options.aperture = sized(SceneAperture::Kind::box, 15.0, 12.0);
  EXPECT_TRUE(compile(system, in, detector_grid(system, in), options).report().notes.empty());
  SceneAperture curve;
  curve.kind = SceneAperture::Kind::curve;
  curve.curve = std::make_shared<const Curve>(
      make_curve("bump.csv", *find_unit("cy/mm"), {5.0, 15.0, 30.0, 60.0}, {0.9, 0.01, 0.5, 0.4}));
  options.aperture = curve;
  EXPECT_FALSE(compile(system, in, detector_grid(system, in), options).report().notes.empty());
}

// The promise holds where the correction amplifies: rounding, tables and left-out factors grow with it.
TEST(PlanAperture, realised_error_stays_below_the_promise) {
  const System<double> system =
      with(bare(), {jitter(0.05), test::gaussian(1.0), Component<double>::make("diffraction")});
  const SampleGrid in = scene_grid(system, 40, 36, 1.0, 1.0);
  const SampleGrid out = detector_grid(system, in);
  const Image scene = random_image(40, 36, 21, 3.0);
  for (const double tolerance : {1e-2, 1e-3, 1e-4})
    for (const Border border : kBorders) {
      PlanOptions options = options_for(scene, border, tolerance);
      options.aperture = sized(SceneAperture::Kind::gaussian, 7.0, 5.5);
      const Plan plan = compile(system, in, out, options);
      const auto corrected = [&](double fx, double fy) {
        const auto inverse = [](double a) { return a * std::sqrt(10.0) >= 1.0 ? 1.0 / a : 10.0 * a; };
        const Complex<double> h = system.otf(Stage::presample, {fx, fy});
        const auto blur = [](double s, double f) { return std::exp(-2.0 * std::pow(M_PI * s * 1e-3 * f, 2)); };
        return std::complex<double>(h.re, h.im) * inverse(blur(7.0, fx)) * inverse(blur(5.5, fy));
      };
      const double rms = rms_distance(run(plan, scene), reference_image(scene, in, out, corrected, border));
      EXPECT_LE(rms / options.scene->std, plan.report().predicted.total()) << plan.explain();
      EXPECT_LE(plan.report().predicted.total(), tolerance);
    }
}

}  // namespace
}  // namespace mtf::test
