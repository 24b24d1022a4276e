// SPDX-License-Identifier: Apache-2.0
// The fast reference against the slow one: two roads to the same sums.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "apps/check/reference_fft.h"
#include "tests/mtf/plan_support.h"

namespace mtf::test {
namespace {

using apps::check::exact_otf;
using apps::check::OtfColumn;
using apps::check::reference_image_fft;
using apps::check::reference_sensor_image;

double largest_difference(const std::vector<double>& a, const std::vector<double>& b) {
  EXPECT_EQ(a.size(), b.size());
  double largest = 0.0;
  for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i) largest = std::max(largest, std::abs(a[i] - b[i]));
  return largest;
}

/// Real and even, complex and not even along x, along y, along both.
std::vector<System<double>> systems() {
  return {with(bare(), {Component<double>::make("diffraction"), footprint(15.0)}),
          with(bare(), {rc(40.0, 0), gaussian(2.0)}), with(bare(), {rc(30.0, 1), motion(20.0, 30.0)}),
          with(bare(), {rc(30.0, 1), rc(60.0, 0)})};
}

TEST(ReferenceFft, equals_the_sums_for_every_border_ratio_and_parity) {
  struct Size {
    std::int64_t width, height;
  };
  const double level = -3.5;
  for (const System<double>& system : systems())
    for (const Border border : kBorders)
      for (const double ratio_x : {1.0, 2.0, 3.0, 3.7})
        for (const double ratio_y : {1.0, 2.0, 2.5})
          for (const Size size : {Size{12, 10}, Size{11, 9}, Size{8, 13}, Size{4, 3}}) {
            const SampleGrid in = scene_grid(system, size.width, size.height, ratio_x, ratio_y);
            const SampleGrid out = detector_grid(system, in);
            const Image scene = random_image(size.width, size.height, 3, 5.0, 2.0);
            const auto slow = reference_image(scene, in, out, otf_of(system, Stage::presample), border, level);
            const OtfColumn otf = exact_otf(system, {Stage::presample}, {}, in);
            const auto fast = reference_image_fft(scene.view(), in, out, otf, border, level, 1);
            ASSERT_LT(largest_difference(slow, fast), 1e-12)
                << size.width << "x" << size.height << " ratios " << ratio_x << ", " << ratio_y << " "
                << kBorderNames[static_cast<std::size_t>(border)];
            const auto single =
                reference_image_fft(scene.view(), in, out, otf_of(system, Stage::presample), border, level, 1);
            ASSERT_LT(largest_difference(slow, single), 1e-12);
          }
}

TEST(ReferenceFft, a_single_pixel_and_a_single_row) {
  const System<double> system = systems()[3];
  for (const Border border : kBorders)
    for (const std::int64_t width : {1, 7}) {
      const SampleGrid in = scene_grid(system, width, 1, 1.0, 1.0);
      const SampleGrid out = detector_grid(system, in);
      const Image scene = random_image(width, 1, 5);
      const auto slow = reference_image(scene, in, out, otf_of(system, Stage::presample), border, 2.0);
      const auto fast =
          reference_image_fft(scene.view(), in, out, exact_otf(system, {Stage::presample}, {}, in), border, 2.0, 1);
      EXPECT_LT(largest_difference(slow, fast), 1e-12);
    }
}

TEST(ReferenceFft, long_trigonometric_sums_keep_their_phase) {
  const System<double> system = systems()[1];
  const SampleGrid in = scene_grid(system, 331, 2, 1.3, 1.0);
  const SampleGrid out = detector_grid(system, in);
  const Image scene = random_image(331, 2, 9);
  const auto slow = reference_image(scene, in, out, otf_of(system, Stage::presample), Border::replicate);
  const auto fast = reference_image_fft(scene.view(), in, out, exact_otf(system, {Stage::presample}, {}, in),
                                        Border::replicate, 0.0, 1);
  EXPECT_LT(largest_difference(slow, fast), 1e-11);  // the slow sums reduce their phases less carefully
}

TEST(ReferenceFft, threads_do_not_change_a_bit) {
  const System<double> system = systems()[2];
  const SampleGrid in = scene_grid(system, 61, 47, 2.0, 1.7);
  const SampleGrid out = detector_grid(system, in);
  const Image scene = random_image(61, 47, 4);
  const OtfColumn otf = exact_otf(system, {Stage::presample}, {}, in);
  EXPECT_EQ(reference_image_fft(scene.view(), in, out, otf, Border::constant, 1.0, 1),
            reference_image_fft(scene.view(), in, out, otf, Border::constant, 1.0, 4));
}

TEST(ReferenceFft, band_averages_and_the_scene_aperture_are_exact) {
  System<double> system = with(bare(), {Component<double>::make("diffraction"), gaussian(1.0)});
  system.optics.wavelength_um.reset();
  system.band = Band{3.4, 4.8};
  const SampleGrid in = scene_grid(system, 14, 12, 2.0, 2.0);
  SceneAperture aperture;
  aperture.kind = SceneAperture::Kind::box;
  aperture.size = {{in.step_x_um, find_unit("um")}, {in.step_y_um, find_unit("um")}, true};
  const OtfColumn otf = exact_otf(system, {Stage::presample}, aperture, in);
  const auto corrected = [&](double fx, double fy) {
    const auto sinc = [](double x) { return x == 0.0 ? 1.0 : std::sin(M_PI * x) / (M_PI * x); };
    const Complex<double> h = system.otf(Stage::presample, {fx, fy});
    return std::complex<double>(h.re, h.im) / (sinc(1e-3 * in.step_x_um * fx) * sinc(1e-3 * in.step_y_um * fy));
  };
  const Image scene = random_image(14, 12, 8);
  const SampleGrid out = detector_grid(system, in);
  EXPECT_LT(largest_difference(reference_image(scene, in, out, corrected, Border::reflect),
                               reference_image_fft(scene.view(), in, out, otf, Border::reflect, 0.0, 1)),
            1e-12);
}

TEST(ReferenceFft, stages_follow_one_another_on_the_detector_grid) {
  System<double> system = systems()[1];
  system.add(Stage::readout, rc(25.0, 0));
  system.add(Stage::postsample, fir({{0, -0.25, 0}, {-0.25, 2.0, -0.25}, {0, -0.25, 0}}));
  const SampleGrid in = scene_grid(system, 24, 18, 2.0, 3.0);
  const SampleGrid out = detector_grid(system, in);
  const Image scene = random_image(24, 18, 6, 1.0);
  for (const Border border : kBorders) {
    const double level = 0.7;
    const auto first = reference_image(scene, in, out, otf_of(system, Stage::presample), border, level);
    const auto sampled = [&](std::int64_t x, std::int64_t y) {
      return first[static_cast<std::size_t>(y * out.width + x)];
    };
    const auto both = [&](double fx, double fy) {
      return otf_of(system, Stage::readout)(fx, fy) * otf_of(system, Stage::postsample)(fx, fy);
    };
    const auto slow = reference_image(sampled, out, out, both, border, level);
    EXPECT_LT(largest_difference(slow, reference_sensor_image(system, scene.view(), in, {}, border, level, 2)), 1e-12);
  }
}

}  // namespace
}  // namespace mtf::test
