// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "tests/mtf/components/one_component.h"

namespace mtf::test {
namespace {

Component<double> boost(double gain, double peak_cy_mm, int axis = 0) {
  auto c = Component<double>::make("boost");
  set(c, "gain", gain);
  set(c, "peak", peak_cy_mm, "cy/mm");
  choose(c, "axis", axis);
  return c;
}

TEST(Boost, values_at_parts_of_the_peak) {
  EXPECT_NEAR(otf_at(boost(3.0, 40.0), 40.0, 7.0).re, 3.0, 1e-15);
  EXPECT_NEAR(otf_at(boost(3.0, 40.0), 20.0, 7.0).re, 2.0, 1e-15);
  EXPECT_NEAR(otf_at(boost(3.0, 40.0, 1), 7.0, 40.0 / 3.0).re, 1.5, 1e-15);
  EXPECT_EQ(otf_at(boost(3.0, 40.0), 0.0, 40.0).re, 1.0);
  EXPECT_EQ(otf_at(boost(1.0, 40.0), 33.0, 40.0).re, 1.0);
}

// Peak at the Nyquist frequency: the digital filter of three taps.
TEST(Boost, is_a_filter_of_three_taps) {
  const System<double> s = detector(10.0, 10.0);
  const auto taps = fir({{-0.25, 1.5, -0.25}});
  for (const double f : {0.0, 1.0, 19.0, 50.0, 77.0, -120.0})
    EXPECT_NEAR(otf_at(boost(2.0, 50.0), f, 3.0, s).re, otf_at(taps, f, 3.0, s).re, 1e-14) << f;
}

}  // namespace
}  // namespace mtf::test
