// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/mtf/components/one_component.h"

namespace mtf::test {
namespace {

Component<double> filter(double x_um, double y_um) {
  auto c = Component<double>::make("birefringent_filter");
  const Unit* um = find_unit("um");
  *std::get<AxisPair<double>*>(c.fields().front().value) = {{x_um, um}, {y_um, um}, true};
  return c;
}

// A separation of one pitch is the filter that has its zero at Nyquist (Greivenkamp 1990); cos(pi/4) at half of it.
TEST(BirefringentFilter, zero_at_nyquist_for_a_separation_of_one_pitch) {
  const double nyquist = 500.0 / 10.0;
  EXPECT_NEAR(otf_at(filter(10.0, 10.0), nyquist, 0.0).re, 0.0, 1e-16);
  EXPECT_NEAR(otf_at(filter(10.0, 10.0), 0.5 * nyquist, 0.0).re, std::numbers::sqrt2 / 2.0, 1e-15);
  EXPECT_NEAR(otf_at(filter(10.0, 10.0), 2.0 * nyquist, 0.0).re, -1.0, 1e-15);
}

// Four equal spots, summed one by one.
TEST(BirefringentFilter, is_the_transform_of_its_four_spots) {
  for (const double fx : {0.0, 7.0, -33.0, 120.0})
    for (const double fy : {0.0, 11.0, 55.0}) {
      double sum = 0.0;
      for (const double x : {-0.003, 0.003})
        for (const double y : {-0.0045, 0.0045}) sum += 0.25 * std::cos(2.0 * std::numbers::pi * (fx * x + fy * y));
      EXPECT_NEAR(otf_at(filter(6.0, 9.0), fx, fy).re, sum, 1e-14) << fx << ' ' << fy;
    }
  EXPECT_EQ(otf_at(filter(0.0, 9.0), 77.0, 0.0).re, 1.0);
}

}  // namespace
}  // namespace mtf::test
