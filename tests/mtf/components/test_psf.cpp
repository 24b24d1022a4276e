// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "mtf/math/special.h"
#include "mtf/plan/plan.h"
#include "tests/mtf/components/one_component.h"

namespace mtf::test {
namespace {

Component<double> psf(Taps<double> samples, double step_um) {
  auto c = Component<double>::make("psf");
  *std::get<Taps<double>*>(field(c, "samples").value) = std::move(samples);
  set(c, "step", step_um, "um");
  return c;
}

/// A Gaussian of standard deviations sx, sy about (x0, y0), all in steps.
Taps<double> gaussian_spot(int half, double sx, double sy, double x0, double y0) {
  Taps<double> rows;
  for (int j = -half; j <= half; ++j) {
    rows.emplace_back();
    for (int k = -half; k <= half; ++k)
      rows.back().push_back(7.0 * std::exp(-0.5 * (std::pow((k - x0) / sx, 2) + std::pow((j - y0) / sy, 2))));
  }
  return rows;
}

// The other route: the transform of a Gaussian in closed form. Folding of exp(-2 pi^2 (1.8/2)^2) = 1e-7 and the cut
// tails of 7 standard deviations are below the tolerance.
TEST(Psf, samples_of_a_gaussian_have_its_otf_and_its_shift) {
  const double step_mm = 0.5e-3, sx = 2.4e-3 / 2.0, sy = 2.0e-3 / 2.0, x0 = 0.65e-3, y0 = -1.1e-3;
  const auto c = psf(gaussian_spot(24, sx / step_mm, sy / step_mm, x0 / step_mm, y0 / step_mm), 0.5);
  for (const auto& [fx, fy] : {std::pair{30.0, 0.0}, {0.0, 90.0}, {120.0, -75.0}, {-200.0, 310.0}, {600.0, 500.0}}) {
    const double modulus = mtf::gaussian(sx * fx).value * mtf::gaussian(sy * fy).value;
    const double phase = -2.0 * kPi * (x0 * fx + y0 * fy);
    const Complex<double> h = otf_at(c, fx, fy);
    EXPECT_NEAR(h.re, modulus * std::cos(phase), 3e-7) << fx << ' ' << fy;
    EXPECT_NEAR(h.im, modulus * std::sin(phase), 3e-7) << fx << ' ' << fy;
  }
  EXPECT_EQ(otf_at(c, 1000.0, 0.0).re, 0.0);
  EXPECT_EQ(otf_at(c, 3.0, -1000.0).re, 0.0);
  EXPECT_EQ(otf_at(c, 0.0, 0.0).re, 1.0);
}

TEST(Psf, symmetric_samples_are_real) {
  const Taps<double> samples{{1, 2, 1}, {2, 9, 2}, {1, 2, 1}};
  const Traits traits = psf(samples, 2.0).traits(detector().context());
  EXPECT_TRUE(traits.real && traits.even_x && traits.even_y && !traits.gain);
  EXPECT_EQ(otf_at(psf(samples, 2.0), 50.0, 70.0).im, 0.0);
  const Traits shifted = psf({{0, 0, 1}, {0, 3, 0}, {0, 0, 1}}, 2.0).traits(detector().context());
  EXPECT_TRUE(!shifted.real && !shifted.even_x && shifted.even_y);
  EXPECT_TRUE(psf({{-1, 4, -1}}, 2.0).traits(detector().context()).gain);
}

// A point of the scene becomes the samples: the whole way through a plan, with right, down and the sum.
TEST(Psf, a_point_becomes_its_samples_in_an_image) {
  System<double> s;
  s.frame = {100.0, 10.0, 10.0, 0.01, 0, 0};
  const Taps<double> samples = gaussian_spot(6, 1.3, 1.1, 1.0, -2.0);
  s.add(Stage::presample, psf(samples, 10.0));
  double sum = 0.0;
  for (const auto& row : samples)
    for (const double sample : row) sum += sample;
  Image in(40, 32), out(40, 32);
  std::fill(in.data(), in.data() + in.size(), 1.0F);
  in.at(20, 16) = 101.0F;
  PlanOptions options;
  options.border = Border::periodic;
  options.tolerance = 1e-4;
  options.scene = summarise(in.view(), options.border, 0.0);
  const SampleGrid grid{40, 32, 10.0, 10.0};
  compile(s, grid, grid, options).run(in.view(), out.view(), 0.0, 1);
  // The highest frequency of the grid is left out: at most 2 x 100 exp(-2 pi^2 (1.1/2)^2) / 32 = 0.016.
  for (int j = -6; j <= 6; ++j)
    for (int k = -6; k <= 6; ++k)
      EXPECT_NEAR(out.at(20 + k, 16 + j),
                  1.0 + 100.0 * samples[static_cast<std::size_t>(j + 6)][static_cast<std::size_t>(k + 6)] / sum, 0.02);
}

TEST(Psf, says_what_it_cannot_be) {
  for (const Taps<double>& bad : {Taps<double>{}, Taps<double>{{}}, Taps<double>{{1, 2}}, Taps<double>{{1}, {1}},
                                  Taps<double>{{1, 2, 1}, {1}, {1, 2, 1}}, Taps<double>{{0, 0, 0}},
                                  Taps<double>{{1, -2, 1}}, Taps<double>{{-1, -2, -1}}})
    EXPECT_TRUE(refused(psf(bad, 2.0), "samples"));
  EXPECT_TRUE(refused(psf(Taps<double>(1, std::vector<double>(1027, 1.0)), 2.0), "samples"));
  const auto warnings = [](const Component<double>& c) { return c.check(detector().context()).size(); };
  EXPECT_EQ(warnings(psf(gaussian_spot(6, 1.5, 1.5, 0.0, 0.0), 2.0)), 0U);
  EXPECT_EQ(warnings(psf(gaussian_spot(3, 0.4, 0.4, 0.0, 0.0), 2.0)), 1U);  // a spot as narrow as its step
}

}  // namespace
}  // namespace mtf::test
