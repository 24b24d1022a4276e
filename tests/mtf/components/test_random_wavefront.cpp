// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "mtf/math/special.h"
#include "tests/mtf/components/one_component.h"

namespace mtf::test {
namespace {

Component<double> random_wavefront(double rms_waves) {
  auto c = Component<double>::make("random_wavefront");
  set(c, "rms", rms_waves);
  return c;
}

// 4 um, 100 mm, F/1: f = 50 cy/mm is a separation of 20 mm in a pupil of 100 mm. By hand: s = 2 pi 0.1, q = 20/40.
TEST(RandomWavefront, by_hand) {
  auto c = random_wavefront(0.1);
  set(c, "correlation", 0.4);
  EXPECT_NEAR(otf_at(c, 50.0, 0.0).re, 0.9163783529, kTenDigits);
  EXPECT_NEAR(otf_at(c, 30.0, 40.0).re, otf_at(c, 50.0, 0.0).re, 1e-15);
  auto length = random_wavefront(0.1);
  set(length, "correlation_length", 40.0);
  EXPECT_EQ(otf_at(length, 50.0, 0.0).re, otf_at(c, 50.0, 0.0).re);
}

// Its definition: the mean of exp(i (phi1 - phi2)) over Gaussian phases of correlation exp(-q^2), by quadrature.
TEST(RandomWavefront, is_the_mean_over_gaussian_phases) {
  auto c = random_wavefront(0.07);
  set(c, "correlation_length", 8.0);
  for (const double f : {1.0, 12.0, 30.0, 90.0}) {
    const double q = f * 0.4 / 8.0, variance = 2.0 * std::pow(2.0 * kPi * 0.07, 2.0) * (1.0 - std::exp(-q * q));
    double mean = 0.0;
    for (int k = -400; k <= 400; ++k)
      mean += 0.02 * std::cos(0.02 * k * std::sqrt(variance)) * std::exp(-0.5 * 0.0004 * k * k) / std::sqrt(2.0 * kPi);
    EXPECT_NEAR(otf_at(c, f, 0.0).re, mean, 1e-13) << f;
  }
}

TEST(RandomWavefront, core_that_stays) {
  auto c = random_wavefront(0.1);
  set(c, "correlation", 1e-3);
  EXPECT_NEAR(otf_at(c, 200.0, 0.0).re, std::exp(-std::pow(2.0 * kPi * 0.1, 2.0)), 1e-15);
  EXPECT_NEAR(otf_at(c, 1e300, 0.0).re, std::exp(-std::pow(2.0 * kPi * 0.1, 2.0)), 1e-15);
}

TEST(RandomWavefront, rms_scales_with_the_wavelength) {
  auto stated = random_wavefront(0.8), same = random_wavefront(0.1);
  set(stated, "wavelength_reference", 0.5);
  for (auto* c : {&stated, &same}) set(*c, "correlation", 0.3);
  EXPECT_NEAR(otf_at(stated, 40.0, 9.0).re, otf_at(same, 40.0, 9.0).re, 1e-15);
}

TEST(RandomWavefront, refusals) {
  EXPECT_TRUE(refused(random_wavefront(0.1), "correlation"));
  auto c = random_wavefront(0.1);
  set(c, "correlation", 0.1);
  System<double> s = detector();
  s.optics.f_number.reset();
  EXPECT_TRUE(refused(c, "aperture", s));
  set(c, "correlation_length", 5.0);
  EXPECT_TRUE(refused(c, "correlation"));
}

}  // namespace
}  // namespace mtf::test
