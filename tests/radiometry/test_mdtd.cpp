// SPDX-License-Identifier: Apache-2.0
#include "radiometry/performance/mdtd.h"

#include <gtest/gtest.h>

#include "tests/expect_error.h"

namespace radiometry {
namespace {

MrtdInput<double> camera() {
  return {.tvh_k = 0.05,
          .vh_k = 0.02,
          .th_k = 0.01,
          .tv_k = 0.015,
          .h_k = 0.007,
          .v_k = 0.009,
          .spacing_x_mrad = 0.1,
          .spacing_y_mrad = 0.12,
          .frame_rate_hz = 30.0};
}

const auto kFlat = [](double) { return 1.0; };

auto gaussian(double sigma_mrad) {
  return [sigma_mrad](double f) { return std::exp(-2.0 * std::pow(mtf::kPi * sigma_mrad * f, 2)); };
}

/// Mean over a box of the box blurred by a Gaussian: the integral of its triangle times the Gaussian.
double mean_image(double w, double sigma) {
  const double a = w / (std::sqrt(2.0) * sigma);
  return std::erf(a) - (1.0 - std::exp(-a * a)) / (a * std::sqrt(mtf::kPi));
}

TEST(Mdtd, by_the_closed_form_of_a_gaussian_blur) {
  const double sigma = 0.08;
  for (const double w : {0.05, 0.2, 0.6, 4.0}) {
    // Noise without filters: sinc^2 up to Nyquist.
    const auto kept = [&](double spacing) {
      double sum = 0.0;
      constexpr int kSteps = 200000;
      const double step = 0.5 / spacing / kSteps;
      for (int i = 0; i < kSteps; ++i) {
        const double x = mtf::kPi * w * (i + 0.5) * step;
        sum += 2.0 * step * std::pow(std::sin(x) / x, 2);
      }
      return spacing * sum;
    };
    const double e_x = kept(0.1), e_y = kept(0.12), e_t = 1.0 / 3.0;
    const double variance = (0.05 * 0.05 * e_t + 0.02 * 0.02) * e_x * e_y + (0.01 * 0.01 * e_t + 0.007 * 0.007) * e_x +
                            (0.015 * 0.015 * e_t + 0.009 * 0.009) * e_y;
    const double expected = 2.5 * std::sqrt(variance) / (mean_image(w, sigma) * mean_image(w, 2.0 * sigma));
    const double value = mdtd_k(camera(), w, 40.0, gaussian(sigma), gaussian(2.0 * sigma), kFlat, kFlat);
    EXPECT_NEAR(value / expected, 1.0, 1e-8) << w;
  }
}

TEST(Mdtd, limits) {
  MrtdInput<double> in = camera();
  in.vh_k = in.th_k = in.tv_k = in.h_k = in.v_k = 0.0;
  // Large: the mean of W^2/(0.1 x 0.12) samples and three frames.
  const double large = mdtd_k(in, 500.0, 1e3, kFlat, kFlat, kFlat, kFlat);
  EXPECT_NEAR(large / (2.5 * 0.05 * std::sqrt(0.1 * 0.12 / 3.0) / 500.0), 1.0, 1e-3);
  // Small: a point source, whose contrast is W^2 over the blur.
  const auto point = [&](double w) { return mdtd_k(in, w, 40.0, gaussian(0.1), gaussian(0.1), kFlat, kFlat); };
  EXPECT_NEAR(point(1e-4) / point(1e-3), 100.0, 1e-2);
  const auto dark = [](double) { return 0.0; };
  EXPECT_EQ(mdtd_k(in, 1.0, 10.0, dark, kFlat, kFlat, kFlat), mtf::kInfinity);
  in.tvh_k = 0.0;
  EXPECT_EQ(mdtd_k(in, 1.0, 10.0, kFlat, kFlat, kFlat, kFlat), 0.0);
  expect_refused({"mdtd:", "target of 0 mrad"}, [&] { mdtd_k(in, 0.0, 10.0, kFlat, kFlat, kFlat, kFlat); });
  in.frame_rate_hz = 0.0;
  expect_refused({"mdtd.frame_rate"}, [&] { mdtd_k(in, 1.0, 10.0, kFlat, kFlat, kFlat, kFlat); });
}

}  // namespace
}  // namespace radiometry
