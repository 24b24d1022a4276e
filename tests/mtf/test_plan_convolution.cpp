// SPDX-License-Identifier: Apache-2.0
// A third route: direct convolution in the pixel domain, in double, with the kernel of the OTF on the defined canvas;
// and odd shapes against the Fourier sums.
#include "tests/mtf/plan_support.h"

namespace mtf::test {
namespace {

// Point spread on a canvas of lx x ly samples: the inverse DFT of the OTF, shared Nyquist terms halved.
std::vector<double> kernel_of(const System<double>& system, const SampleGrid& in, std::int64_t lx, std::int64_t ly) {
  std::vector<double> kernel(static_cast<std::size_t>(lx * ly));
  const auto turns = [](std::int64_t k, std::int64_t d, std::int64_t n) {
    return 2.0 * M_PI * static_cast<double>(k * d % n) / static_cast<double>(n);
  };
  std::vector<std::complex<double>> rows(static_cast<std::size_t>((lx + 1) * ly));
  for (std::int64_t kx = -(lx / 2); kx <= lx / 2; ++kx)
    for (std::int64_t dy = 0; dy < ly; ++dy) {
      std::complex<double> sum = 0.0;
      for (std::int64_t ky = -(ly / 2); ky <= ly / 2; ++ky) {
        const double weight = (2 * std::abs(kx) == lx ? 0.5 : 1.0) * (2 * std::abs(ky) == ly ? 0.5 : 1.0);
        const Complex<double> h =
            system.otf(Stage::presample, {1e3 * static_cast<double>(kx) / (static_cast<double>(lx) * in.step_x_um),
                                          1e3 * static_cast<double>(ky) / (static_cast<double>(ly) * in.step_y_um)});
        sum += weight * std::complex<double>(h.re, h.im) * std::polar(1.0, turns(ky, dy, ly));
      }
      rows[static_cast<std::size_t>((kx + lx / 2) * ly + dy)] = sum;
    }
  for (std::int64_t dy = 0; dy < ly; ++dy)
    for (std::int64_t dx = 0; dx < lx; ++dx) {
      std::complex<double> sum = 0.0;
      for (std::int64_t kx = -(lx / 2); kx <= lx / 2; ++kx)
        sum += rows[static_cast<std::size_t>((kx + lx / 2) * ly + dy)] * std::polar(1.0, turns(kx, dx, lx));
      kernel[static_cast<std::size_t>(dy * lx + dx)] = sum.real() / static_cast<double>(lx * ly);
    }
  return kernel;
}

TEST(PlanConvolution, equals_direct_convolution_to_float_accuracy) {
  for (const auto& system : {with(bare(), {Component<double>::make("diffraction"), footprint(12.0)}),
                             with(bare(), {test::gaussian(6.0), rc(30.0, 0), motion(11.0, 60.0)})})
    // Odd ratios: a scene sample stands at every detector centre.
    for (const std::int64_t ratio : {1, 3})
      for (const auto& [width, height] : {std::pair<std::int64_t, std::int64_t>{12, 9}, {1, 15}, {15, 1}, {9, 21}})
        for (const Border border : kBorders) {
          const std::int64_t rx = width == 1 ? 1 : ratio, ry = height == 1 ? 1 : ratio;
          const SampleGrid in = scene_grid(system, width, height, static_cast<double>(rx), static_cast<double>(ry));
          const SampleGrid out = detector_grid(system, in);
          const Image scene = random_image(width, height, 3, 1.0);
          const double border_value = 0.3;
          const Plan plan = compile(system, in, out, options_for(scene, border, 1e-5, border_value));
          const Image image = run(plan, scene, border_value);
          const std::int64_t lx = canvas_length(border, width), ly = canvas_length(border, height);
          const auto kernel = kernel_of(system, in, lx, ly);
          for (std::int64_t j = 0; j < out.height; ++j)
            for (std::int64_t i = 0; i < out.width; ++i) {
              double sum = 0.0;
              for (std::int64_t dy = 0; dy < ly; ++dy)
                for (std::int64_t dx = 0; dx < lx; ++dx) {
                  const std::int64_t x = border_source(border, i * rx + rx / 2 - dx, width);
                  const std::int64_t y = border_source(border, j * ry + ry / 2 - dy, height);
                  sum += kernel[static_cast<std::size_t>(dy * lx + dx)] *
                         (x < 0 || y < 0 ? border_value : static_cast<double>(scene.at(x, y)));
                }
              ASSERT_NEAR(image.at(i, j), sum, 2e-6) << width << "x" << height << "\n" << plan.explain();
            }
        }
}

TEST(PlanConvolution, odd_primes_and_one_pixel_wide_images_equal_the_fourier_sums) {
  const System<double> system = with(bare(), {Component<double>::make("diffraction"), footprint(12.0), rc(50.0, 1)});
  const System<double> even = with(bare(), {Component<double>::make("diffraction"), footprint(12.0)});
  struct Case {
    std::int64_t width, height;
    double ratio_x, ratio_y;
    Border border;
    const System<double>* system;
  };
  for (const Case& c : {Case{127, 131, 1.0, 1.0, Border::periodic, &system},
                        {127, 131, 3.7, 2.0, Border::periodic, &even},
                        {127, 131, 2.0, M_PI, Border::reflect, &even},
                        {257, 1, 2.0, 1.0, Border::reflect, &even},
                        {257, 1, 3.7, 1.0, Border::replicate, &system},
                        {1, 257, 1.0, 4.0, Border::constant, &system},
                        {1, 257, 1.0, M_PI, Border::reflect, &system},
                        {1, 1, 1.0, 1.0, Border::constant, &system}}) {
    const SampleGrid in = scene_grid(*c.system, c.width, c.height, c.ratio_x, c.ratio_y);
    const SampleGrid out = detector_grid(*c.system, in);
    const Image scene = random_image(c.width, c.height, 8, 2.0);
    const PlanOptions options = options_for(scene, c.border, 1e-5, 1.0);
    const Plan plan = compile(*c.system, in, out, options);
    const double rms = rms_distance(
        run(plan, scene, 1.0), reference_image(scene, in, out, otf_of(*c.system, Stage::presample), c.border, 1.0));
    EXPECT_LE(rms / (options.scene ? options.scene->std : 1.0), options.scene ? plan.report().predicted.total() : 1e-6)
        << c.width << "x" << c.height << "\n"
        << plan.explain();
  }
}

}  // namespace
}  // namespace mtf::test
