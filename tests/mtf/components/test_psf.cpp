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
  EXPECT_EQ(warnings(psf(gaussian_spot(9, 1.5, 1.5, 0.0, 0.0), 2.0)), 0U);
  EXPECT_EQ(warnings(psf(gaussian_spot(3, 0.4, 0.4, 0.0, 0.0), 2.0)), 1U);  // a spot as narrow as its step
}

/// What a sampled PSF may be wrong by, by its own account: 1 where it is refused, 1e-3 where it says nothing.
double stated_bound(const Component<double>& c) {
  for (const Problem& problem : c.check(detector().context())) {
    if (problem.field != "samples") continue;
    if (problem.error) return 1.0;
    const std::string before = "wrong by up to ";
    return std::stod(problem.text.substr(problem.text.find(before) + before.size()));
  }
  return 1e-3;
}

// Shapes whose OTF is known in closed form, cut off at many radii: what the cut leaves out of the OTF is never more
// than is said. Half a cycle a sample is well beyond the OTF of each.
TEST(Psf, light_beyond_the_samples_is_said_or_refused) {
  struct Shape {
    const char* name;
    double (*psf)(double);
    double (*otf)(double);  ///< over cycles a sample
  };
  const Shape shapes[] = {{"gaussian, 3 samples", [](double r) { return std::exp(-r * r / 18.0); },
                           [](double f) { return mtf::gaussian(3.0 * f).value; }},
                          {"exponential, 4 samples", [](double r) { return std::exp(-r / 4.0); },
                           [](double f) { return std::pow(1.0 + std::pow(8.0 * kPi * f, 2), -1.5); }},
                          {"moffat, 2 samples", [](double r) { return std::pow(1.0 + r * r / 4.0, -1.5); },
                           [](double f) { return std::exp(-4.0 * kPi * f); }},
                          {"airy, cutoff at 0.2 cycles a sample",
                           [](double r) {
                             return r == 0.0 ? 1.0
                                             : std::pow(2.0 * std::cyl_bessel_j(1, 0.2 * kPi * r) / (0.2 * kPi * r), 2);
                           },
                           [](double f) {
                             const double nu = f / 0.2;
                             return nu >= 1.0 ? 0.0 : 2.0 / kPi * (std::acos(nu) - nu * std::sqrt(1.0 - nu * nu));
                           }}};
  for (const Shape& shape : shapes) {
    int said = 0, refusals = 0;
    for (const int half : {2, 3, 5, 7, 8, 10, 13, 18, 27, 40, 64}) {
      Taps<double> samples;
      for (int j = -half; j <= half; ++j) {
        samples.emplace_back();
        for (int k = -half; k <= half; ++k) samples.back().push_back(shape.psf(std::hypot(j, k)));
      }
      const auto c = psf(std::move(samples), 1.0);
      const double bound = stated_bound(c);
      refusals += bound == 1.0;
      said += bound > 1e-3 && bound < 1.0;
      double worst = 0.0;
      for (const double f : {0.005, 0.01, 0.02, 0.04, 0.07, 0.1, 0.15})
        worst = std::max({worst, std::abs(otf_at(c, 1e3 * f, 0.0).re - shape.otf(f)),
                          std::abs(otf_at(c, 700.0 * f, 700.0 * f).re - shape.otf(0.7 * std::sqrt(2.0) * f))});
      EXPECT_LE(worst, bound) << shape.name << ", " << half;
    }
    EXPECT_GT(refusals, 0) << shape.name;
    EXPECT_GT(said, 0) << shape.name;
  }
}

}  // namespace
}  // namespace mtf::test
