// SPDX-License-Identifier: Apache-2.0
// Plans that know their scene's spectrum: what is left out is charged to the frequencies where this scene has its
// power, at the places where a bound could be lost: aliases, alias zones inside of a cell, padded canvases, filters
// after the sampling, other scenes.
#include "mtf/engines/fft/scene_spectrum.h"

#include "mtf/plan/sensor_plan.h"
#include "tests/mtf/plan_support.h"

namespace mtf::test {
namespace {

Image waves(std::int64_t width, std::int64_t height, double cycles) {
  return image_of(width, height, [&](auto x, auto) {
    return std::cos(2.0 * M_PI * (static_cast<double>(x) + 0.5) * cycles / static_cast<double>(width));
  });
}

PlanOptions knowing(const Image& scene, Border border, double tolerance) {
  PlanOptions options = options_for(scene, border, tolerance);
  options.spectrum = scene_spectrum(scene.view(), border, 1);
  return options;
}

void expect_kept(const System<double>& system, const SampleGrid& in, const Image& scene, const PlanOptions& options) {
  const Plan plan = compile(system, in, detector_grid(system, in), options);
  const auto expected = reference_image(scene, in, plan.out(), otf_of(system, Stage::presample), options.border);
  EXPECT_LE(rms_distance(run(plan, scene), expected) / options.scene->std, plan.report().predicted.total())
      << plan.explain();
}

TEST(PlanSpectrum, is_of_the_scene_and_not_of_what_the_detector_samples) {
  System<double> system;
  system.frame = {100.0, 15.0, 15.0, 0.01, 0, 0};
  system.add(Stage::postsample, fir({{0, 0, 0}, {-0.02, 1.04, -0.02}, {0, 0, 0}}));
  for (const std::int64_t ratio : {2, 4}) {
    const double step = 15.0 / static_cast<double>(ratio);
    const SampleGrid in{64 * ratio, 32 * ratio, step, step};
    const Image scene = waves(in.width, in.height, 29.0);  // just below the detector's Nyquist frequency
    const PlanOptions options = knowing(scene, Border::periodic, 0.05);
    const SensorPlan plan = compile_sensor(system, in, options);
    const ImageView<const float> view = scene.view();
    const Image image = std::move(plan.run(std::span(&view, 1)).front());
    const auto one = [](double, double) { return std::complex<double>(1.0, 0.0); };
    const auto samples = reference_image(scene, in, plan.out(), one, options.border);
    Image sampled(plan.out().width, plan.out().height);
    for (std::int64_t i = 0; i < sampled.size(); ++i)
      sampled.data()[i] = static_cast<float>(samples[static_cast<std::size_t>(i)]);
    const auto expected =
        reference_image(sampled, plan.out(), plan.out(), otf_of(system, Stage::postsample), options.border);
    EXPECT_LE(rms_distance(image, expected) / options.scene->std, plan.predicted_error) << ratio;
  }
}

TEST(PlanSpectrum, dropped_components_count_the_aliases_of_the_whole_scene) {
  System<double> system = with(bare(15.0, 15.0), {Component<double>::make("diffraction"), gaussian(0.7)});
  system.optics.f_number = 8.0;
  const SampleGrid in{1024, 16, 3.75, 3.75};
  const Image scene = waves(in.width, in.height, 31.0);
  PlanOptions options = knowing(scene, Border::periodic, 0.02);
  for (const Method method : {Method::fft_cut, Method::fft_float}) {
    options.method = method;
    expect_kept(system, in, scene, options);
  }
}

TEST(PlanSpectrum, zones_that_end_inside_of_a_cell_are_counted_twice) {
  // Cycles 127 and 129 of 1280 alias onto one another at ratio 5, where they lie in one cell.
  const Image scene = image_of(1280, 16, [](auto x, auto) {
    const double turn = 2.0 * M_PI * (static_cast<double>(x) - 2.0) / 1280.0;
    return std::cos(127.0 * turn) + std::cos(129.0 * turn);
  });
  double squares = 0.0;
  for (std::int64_t j = 0; j < 256; ++j) squares += std::pow(scene.at(5 * j + 2, 0), 2);
  const std::vector<double> ones(static_cast<std::size_t>(SceneSpectrum::kRows * SceneSpectrum::kColumns), 1.0);
  const auto spectrum = scene_spectrum(scene.view(), Border::periodic, 1);
  EXPECT_GE(spectrum->rms_error(ones, 5.0, 5.0), std::sqrt(squares / 256.0) / statistics(scene.view()).std);
}

TEST(PlanSpectrum, a_padded_canvas_is_not_the_scene) {
  // No component at all: the canvas is shortened without any wrap-around, and a ramp jumps where it ends.
  const System<double> system = bare(15.0, 15.0);
  for (const std::int64_t width : {633, 634}) {
    const SampleGrid in{width, 24, 5.0, 5.0};
    const Image scene = image_of(width, 24, [](auto x, auto) { return static_cast<double>(x); });
    PlanOptions options = knowing(scene, Border::reflect, 1e-2);
    expect_kept(system, in, scene, options);
    options.method = Method::fft_float;
    expect_kept(system, in, scene, options);
  }
}

TEST(PlanSpectrum, of_another_scene_is_refused) {
  const System<double> system = with(bare(15.0, 15.0), {gaussian(20.0)});
  const Image scene = random_image(40, 30, 1);
  PlanOptions options = knowing(scene, Border::reflect, 1e-2);
  const SampleGrid in = scene_grid(system, 40, 30, 1.0, 1.0), other = scene_grid(system, 30, 40, 1.0, 1.0);
  EXPECT_NO_THROW(compile(system, in, detector_grid(system, in), options));
  EXPECT_THROW(compile(system, other, detector_grid(system, other), options), UsageError);
  options.border = Border::periodic;
  EXPECT_THROW(compile(system, in, detector_grid(system, in), options), UsageError);
}

TEST(PlanSpectrum, one_way_is_looked_at_afresh_when_blur_grows_slowly) {
  const auto blurred = [](double sigma_um) { return with(bare(15.0, 15.0), {gaussian(sigma_um)}); };
  const SampleGrid in = scene_grid(blurred(8.0), 256, 256, 1.0, 1.0);
  const Image scene = random_image(256, 256, 2);
  const PlanOptions options = options_for(scene, Border::reflect, 3e-2);
  Plan plan = compile(blurred(8.0), in, detector_grid(blurred(8.0), in), options);
  double sigma_um = 8.0;
  for (; sigma_um < 200.0; sigma_um *= 1.05) plan = plan.with(blurred(sigma_um));
  const Plan fresh = compile(blurred(sigma_um / 1.05), in, detector_grid(blurred(8.0), in), options);
  const auto cost = [](const Plan& p) {
    for (const Candidate& c : p.report().candidates)
      if (c.reason.empty()) return c.cost_ms;
    return 0.0;
  };
  EXPECT_LE(cost(plan), 1.6 * cost(fresh));
}

}  // namespace
}  // namespace mtf::test
