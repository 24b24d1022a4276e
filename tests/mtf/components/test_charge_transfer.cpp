// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <complex>

#include "mtf/math/special.h"
#include "tests/mtf/components/one_component.h"

namespace mtf::test {
namespace {

Component<double> charge_transfer(double inefficiency, int transfers, int axis = 0) {
  auto c = Component<double>::make("charge_transfer");
  set(c, "inefficiency", inefficiency);
  set(c, "transfers", transfers);
  choose(c, "axis", axis);
  return c;
}

TEST(ChargeTransfer, ten_digits_by_modulus) {
  const std::array values{.9972187155, .9896886042, .9697504236, .9607894392};
  for (std::size_t i = 0; i < values.size(); ++i)
    EXPECT_NEAR(modulus(otf_at(charge_transfer(1e-5, 2000), kGoldenFrequencies[i], 0.0)), values[i], kTenDigits) << i;
}

// The spread itself: after N transfers k packets later there is a Poisson share of it, towards +axis.
TEST(ChargeTransfer, trails_towards_the_positive_axis) {
  const double loss = 0.3;
  for (const int axis : {0, 1})
    for (const double f : {1.0, 13.0, 29.0, -40.0}) {
      std::complex<double> sum = 0.0;
      double share = std::exp(-loss);
      for (int k = 0; k < 30; ++k) {
        sum += share * std::polar(1.0, -2.0 * kPi * f * 0.001 * (axis == 0 ? 17.0 : 20.0) * k);
        share *= loss / (k + 1);
      }
      const auto h =
          otf_at(charge_transfer(3e-4, 1000, axis), axis == 0 ? f : 3.0, axis == 0 ? 3.0 : f, detector(17.0, 20.0));
      EXPECT_NEAR(h.re, sum.real(), 1e-14) << axis << f;
      EXPECT_NEAR(h.im, sum.imag(), 1e-14) << axis << f;
    }
}

TEST(ChargeTransfer, repeats_with_the_sampling_frequency_and_no_loss_is_one) {
  const auto c = charge_transfer(1e-4, 3000);
  const double sampling = 1000.0 / 17.0;
  EXPECT_NEAR(otf_at(c, 7.0, 0.0).im, otf_at(c, 7.0 + sampling, 0.0).im, 1e-14);
  for (const auto& none : {charge_transfer(0.0, 3000), charge_transfer(1e-4, 0)}) {
    EXPECT_EQ(otf_at(none, 23.0, 0.0).re, 1.0);
    EXPECT_EQ(otf_at(none, 23.0, 0.0).im, 0.0);
  }
}

}  // namespace
}  // namespace mtf::test
