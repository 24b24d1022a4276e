// SPDX-License-Identifier: Apache-2.0
// The spectral filter in double: images are float32, so its result has to be the reference, rounded once.
#include <gtest/gtest.h>

#include "mtf/plan/plan_parts.h"
#include "tests/mtf/plan_support.h"

namespace mtf::test {
namespace {

AxisTransform axis_job(Basis basis, Border border, std::int64_t n, double step_um, std::int64_t outputs,
                       double pitch_um) {
  AxisTransform job;
  job.border = border;
  job.samples = n;
  job.outputs = outputs;
  job.pitch_um = pitch_um;
  job.frequency = {basis, basis == Basis::cosine ? n : canvas_length(border, n), step_um};
  const double pitches = static_cast<double>(job.frequency.length) * step_um / pitch_um;
  job.resampling = is_whole(pitches) ? Resampling::fold : Resampling::chirp;
  if (job.resampling == Resampling::fold) job.out_length = std::llround(pitches);
  job.keep = job.frequency.half_count();
  return job;
}

struct Case {
  System<double> system;
  bool cosine_x, cosine_y;
  Border border;
  double ratio_x, ratio_y;
  bool odd_x = false, odd_y = false;
};

std::vector<Case> cases() {
  const auto even = with(bare(), {Component<double>::make("diffraction"), motion(9.0, 0.0)});
  const auto uneven = with(bare(), {Component<double>::make("diffraction"), rc(40.0, 0)});
  const auto slanted = with(bare(), {Component<double>::make("diffraction"), motion(9.0, 30.0)});
  const auto down = with(bare(), {Component<double>::make("diffraction"), rc(40.0, 1)});
  const auto any = with(bare(), {Component<double>::make("diffraction"), rc(40.0, 0), rc(20.0, 1), motion(9.0, 30.0)});
  std::vector<Case> list;
  for (const auto& [x, y] : {std::pair{1.0, 1.0}, {2.0, 4.0}, {3.7, M_PI}, {2.0, 2.3}}) {
    for (const Border border : kBorders)
      for (const System<double>& system : {even, uneven, slanted}) list.push_back({system, false, false, border, x, y});
    list.push_back({even, true, true, Border::reflect, x, y});
    list.push_back({even, false, true, Border::reflect, x, y});
    list.push_back({uneven, false, true, Border::reflect, x, y});
    // Cosines and sines: what is odd along x, along y, along both together, and all of it.
    list.push_back({uneven, true, true, Border::reflect, x, y, true, false});
    list.push_back({down, true, true, Border::reflect, x, y, false, true});
    list.push_back({slanted, true, true, Border::reflect, x, y, true, true});
    list.push_back({any, true, true, Border::reflect, x, y, true, true});
  }
  return list;
}

constexpr double kLevel = 8.5;

std::shared_ptr<const SpectralFilter> filter_of(const Case& c, const SampleGrid& in, const SampleGrid& out,
                                                Precision precision, const Engine* relative = nullptr) {
  AxisTransform x =
      axis_job(c.cosine_x ? Basis::cosine : Basis::fourier, c.border, in.width, in.step_x_um, out.width, out.step_x_um);
  AxisTransform y = axis_job(c.cosine_y ? Basis::cosine : Basis::fourier, c.border, in.height, in.step_y_um, out.height,
                             out.step_y_um);
  x.odd = c.odd_x;
  y.odd = c.odd_y;
  constexpr std::array stages{Stage::presample};
  const FactoredOtf sampler(c.system, stages, {}, {.fx_max = 500.0 / in.step_x_um, .fy_max = 500.0 / in.step_y_um});
  return make_spectral_filter(sampler, {x, y, precision}, fft::Rigor::estimate, 1, relative);
}

Image filtered(const Engine& filter, const Image& scene, const SampleGrid& out, double mean, int threads) {
  Image image(out.width, out.height);
  filter.run({{scene.view(), image.view(), mean, 0.25, false, 1.0, kLevel}}, threads);
  return image;
}

TEST(EngineDouble, result_is_the_reference_rounded_once) {
  double squares = 0.0, count = 0.0;
  for (const Case& c : cases())
    for (const auto& [width, height] : {std::pair{40, 36}, {23, 37}}) {
      const SampleGrid in = scene_grid(c.system, width, height, c.ratio_x, c.ratio_y);
      const SampleGrid out = detector_grid(c.system, in);
      const Image scene = random_image(width, height, 7, 10.0);
      const auto filter = filter_of(c, in, out, Precision::double_precision);
      const Image image = filtered(*filter, scene, out, 10.0, 1);
      const auto expected = reference_image(scene, in, out, otf_of(c.system, Stage::presample), c.border, kLevel);
      for (std::int64_t i = 0; i < image.size(); ++i) {
        const double value = expected[static_cast<std::size_t>(i)], error = image.data()[i] - value;
        const auto spacing = std::ldexp(1.0, std::ilogb(value) - 23);
        ASSERT_LE(std::abs(error), 0.5 * spacing + 1e-12)
            << kBorderNames[static_cast<std::size_t>(c.border)] << " " << c.ratio_x << " " << c.cosine_x << c.cosine_y;
        squares += std::pow(error / value, 2);
        count += 1.0;
      }
    }
  EXPECT_LT(std::sqrt(squares / count), 3e-8);
}

TEST(EngineDouble, number_of_threads_changes_no_bit_and_relatives_share) {
  for (const Case& c : cases()) {
    const SampleGrid in = scene_grid(c.system, 70, 90, c.ratio_x, c.ratio_y);
    const SampleGrid out = detector_grid(c.system, in);
    const Image scene = random_image(70, 90, 8, 10.0);
    const auto filter = filter_of(c, in, out, Precision::double_precision);
    const Image one = filtered(*filter, scene, out, 10.0, 1);
    for (const int threads : {2, 3, 0}) EXPECT_TRUE(same_bits(one, filtered(*filter, scene, out, 10.0, threads)));
    const auto again = filter_of(c, in, out, Precision::double_precision, filter.get());
    EXPECT_TRUE(same_bits(one, filtered(*again, scene, out, 10.0, 1)));
    // A relative of the other precision has nothing to share.
    const auto single = filter_of(c, in, out, Precision::single_precision, filter.get());
    EXPECT_FALSE(same_bits(one, filtered(*single, scene, out, 10.0, 1)));
    EXPECT_NEAR(single->largest_gain(), filter->largest_gain(), 1e-6);
    EXPECT_NEAR(filter->largest_gain(), 1.0, 1e-12);
  }
}

}  // namespace
}  // namespace mtf::test
