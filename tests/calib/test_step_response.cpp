// SPDX-License-Identifier: Apache-2.0
#include "calib/edge/step_response.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>

#include "mtf/error.h"

namespace {

using calib::slice_nodes;
using calib::SliceNodes;
using calib::StepResponse;
using mtf::Complex;
using std::numbers::pi;

double gaussian_mtf(double sigma, double f) { return std::exp(-2.0 * pi * pi * sigma * sigma * f * f); }
double normal_cdf(double x) { return 0.5 * std::erfc(-x / std::numbers::sqrt2); }

// E of a Gaussian is the normal distribution; of a shifted one the same distribution, moved.
TEST(StepResponse, GaussianAndItsShift) {
  for (const double sigma : {0.2, 0.4, 1.5})
    for (const double shift : {0.0, 0.3}) {
      const SliceNodes nodes = slice_nodes(1.1 / sigma, 40.0);
      std::vector<Complex<double>> h, by_sigma;
      for (const double f : nodes.f_cy_px) {
        const double m = gaussian_mtf(sigma, f), a = -2.0 * pi * f * shift;
        h.push_back({m * std::cos(a), m * std::sin(a)});
        const double slope = -4.0 * pi * pi * sigma * f * f;
        by_sigma.push_back({slope * h.back().re, slope * h.back().im});
      }
      const StepResponse table(nodes, std::array{h, by_sigma});
      std::array<double, 2> e{};
      for (double d = -40.0; d <= 40.0; d += 0.0371) {
        const double slope = table.at(d, e), x = (d - shift) / sigma;
        const double density = std::exp(-0.5 * x * x) / std::sqrt(2.0 * pi);
        // The table ends at a modulus of 4e-11; its cubics have 20 knots a period there.
        EXPECT_NEAR(e[0], normal_cdf(x), 1e-7) << sigma << ' ' << shift << ' ' << d;
        EXPECT_NEAR(e[1], -x * density / sigma, 2e-6 / sigma) << sigma << ' ' << shift << ' ' << d;
        EXPECT_NEAR(slope, density / sigma, 2e-5 / sigma) << sigma << ' ' << shift << ' ' << d;
      }
    }
}

// A pixel alone: E is a ramp. Its OTF falls as 1/f only, so the cut at f = 40 leaves ripples of 1 / (2 pi^2 40).
TEST(StepResponse, RampOfABox) {
  const SliceNodes nodes = slice_nodes(40.0, 4.0);
  std::vector<Complex<double>> h;
  for (const double f : nodes.f_cy_px) h.push_back({std::sin(pi * f) / (pi * f), 0.0});
  const StepResponse table(nodes, std::array{h});
  std::array<double, 1> e{};
  for (double d = -4.0; d <= 4.0; d += 0.0123) {
    table.at(d, e);
    EXPECT_NEAR(e[0], std::clamp(d + 0.5, 0.0, 1.0), 1.3e-3) << d;
  }
}

// The tail of diffraction, 1 - E = 2 S / (pi^3 d) + O(d^-3), S = lambda N / pitch, from the cusp -(4/pi) S of its MTF.
TEST(StepResponse, TailOfDiffraction) {
  const double s = 0.93;
  const SliceNodes nodes = slice_nodes(1.0 / s, 120.0);
  std::vector<Complex<double>> h;
  for (const double f : nodes.f_cy_px) {
    const double nu = f * s;
    h.push_back({2.0 / pi * (std::acos(nu) - nu * std::sqrt(1.0 - nu * nu)), 0.0});
  }
  const StepResponse table(nodes, std::array{h});
  std::array<double, 1> e{};
  for (const double d : {20.0, 50.0, 119.0}) {
    table.at(d, e);
    EXPECT_NEAR((1.0 - e[0]) * d, 2.0 * s / (pi * pi * pi), 2.0 / (d * d)) << d;
    const double bright = e[0];
    table.at(-d, e);
    EXPECT_NEAR(e[0], 1.0 - bright, 1e-15);
  }
}

TEST(StepResponse, RefusesWhatHasNoEnd) {
  EXPECT_THROW(slice_nodes(0.0, 10.0), mtf::UsageError);
  EXPECT_THROW(slice_nodes(1.0, std::nan("")), mtf::UsageError);
  EXPECT_THROW(slice_nodes(1e9, 1e3), mtf::UsageError);
  EXPECT_NO_THROW(slice_nodes(3.0, 500.0, std::array{0.5, 0.5, 7.0, -1.0}));
}

}  // namespace
