// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <complex>

#include "mtf/math/special.h"
#include "tests/mtf/components/one_component.h"

namespace mtf::test {
namespace {

Component<double> bolometer(double tau_s, double velocity_um_s, int axis = 0) {
  auto c = Component<double>::make("bolometer");
  set(c, "time_constant", tau_s);
  set(c, "velocity", velocity_um_s);
  choose(c, "axis", axis);
  return c;
}

TEST(Bolometer, ten_digits_by_modulus) {
  const std::array values{.9878867019, .9540282164, .8467330160, .7344662434};
  for (std::size_t i = 0; i < values.size(); ++i)
    EXPECT_NEAR(modulus(otf_at(bolometer(0.010, 500.0), kGoldenFrequencies[i], 0.0)), values[i], kTenDigits) << i;
}

// Its definition: t ago the point was at -v t; that position has the weight exp(-t/tau)/tau.
TEST(Bolometer, tail_lies_behind_the_moving_image) {
  const double tau = 0.010, step = 1e-3;
  for (const double v_mm_s : {0.5, -3.0})
    for (const double f : {2.0, 20.0, -70.0}) {
      std::complex<double> sum = 0.0;  // Simpson over t/tau from 0 to 40
      for (int k = 0; k <= 40000; ++k) {
        const double t = step * k, weight = (k == 0 || k == 40000 ? 1.0 : k % 2 == 1 ? 4.0 : 2.0) * step / 3.0;
        sum += weight * std::exp(-t) * std::polar(1.0, -2.0 * kPi * f * (-v_mm_s * tau * t));
      }
      for (const int axis : {0, 1}) {
        const auto h = otf_at(bolometer(tau, 1e3 * v_mm_s, axis), axis == 0 ? f : 1.0, axis == 0 ? 1.0 : f);
        EXPECT_NEAR(h.re, sum.real(), 1e-9) << v_mm_s << f;
        EXPECT_NEAR(h.im, sum.imag(), 1e-9) << v_mm_s << f;
      }
    }
}

TEST(Bolometer, rate_is_velocity_by_the_focal_length) {
  auto c = Component<double>::make("bolometer");
  set(c, "time_constant", 0.010);
  EXPECT_TRUE(refused(c, "velocity"));
  set(c, "rate", 5000.0);  // 5 mrad/s x 100 mm
  EXPECT_FALSE(refused(c, "velocity"));
  EXPECT_NEAR(otf_at(c, 20.0, 0.0).im, otf_at(bolometer(0.010, 500.0), 20.0, 0.0).im, 1e-16);
  set(c, "velocity", 500.0);
  EXPECT_TRUE(refused(c, "velocity"));
}

}  // namespace
}  // namespace mtf::test
