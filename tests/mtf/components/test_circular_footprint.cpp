// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "mtf/math/special.h"
#include "tests/mtf/components/one_component.h"

namespace mtf::test {
namespace {

Component<double> circle(double diameter_um) {
  auto c = Component<double>::make("circular_footprint");
  set(c, "diameter", diameter_um, "um");
  return c;
}

// Its definition: the projection of a disc, sqrt(1 - t^2), summed with Gauss-Chebyshev nodes of the second kind.
TEST(CircularFootprint, is_the_transform_of_a_disc) {
  constexpr int kNodes = 200;
  for (const double f : {0.0, 0.01, 2.0, 30.0, 66.0, 82.0, 150.0, 400.0}) {
    double sum = 0.0;
    for (int k = 1; k <= kNodes; ++k) {
      const double t = cos_pi(k / (kNodes + 1.0)), s = sin_pi(k / (kNodes + 1.0));
      sum += 2.0 / (kNodes + 1.0) * s * s * cos_pi(2.0 * f * 0.0075 * t);
    }
    EXPECT_NEAR(otf_at(circle(15.0), f, 0.0).re, sum, 1e-14) << f;
    EXPECT_NEAR(otf_at(circle(15.0), 0.6 * f, -0.8 * f).re, sum, 1e-14) << f;
  }
}

TEST(CircularFootprint, ellipse_is_a_stretched_circle) {
  auto c = circle(0.0);
  set_xy(c, "diameter", 10.0, 20.0, "um");
  EXPECT_NEAR(otf_at(c, 31.0, 12.0).re, otf_at(circle(10.0), 31.0, 24.0).re, 1e-15);
  EXPECT_NEAR(otf_at(circle(15.0), 1.2196698912665045 / 0.015, 0.0).re, 0.0, 1e-15);  // first zero, 3.8317/pi
}

}  // namespace
}  // namespace mtf::test
