// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "mtf/math/special.h"
#include "tests/mtf/components/one_component.h"

namespace mtf::test {
namespace {

Component<double> binning(int columns, int rows) {
  auto c = Component<double>::make("binning");
  set(c, "columns", columns);
  set(c, "rows", rows);
  return c;
}

TEST(Binning, is_the_mean_over_its_pixels) {
  auto c = binning(3, 2);
  set_xy(c, "spacing", 5.0, 7.0, "um");
  for (const double fx : {0.0, 3.0, 66.7, 100.0, 199.9, 200.0, 431.0})
    for (const double fy : {0.0, 71.4, 142.9, 500.0}) {
      const double x = (1.0 + 2.0 * std::cos(2.0 * kPi * fx * 0.005)) / 3.0, y = std::cos(kPi * fy * 0.007);
      EXPECT_NEAR(otf_at(c, fx, fy).re, x * y, 2e-14) << fx << " " << fy;
    }
}

// frame.pitch is that of the binned output: without gaps, native footprints summed are one of the output's pitch.
TEST(Binning, of_pixels_without_gaps_is_one_large_pixel) {
  const System<double> system = detector(18.0, 24.0);
  auto native = Component<double>::make("footprint"), whole = native;
  set_xy(native, "width", 6.0, 6.0, "um");
  set_xy(whole, "width", 18.0, 24.0, "um");
  for (const double fx : {1.0, 27.0, 55.0, 160.0})
    for (const double fy : {0.0, 20.0, 170.0})
      EXPECT_NEAR(otf_at(binning(3, 4), fx, fy, system).re * otf_at(native, fx, fy, system).re,
                  otf_at(whole, fx, fy, system).re, 1e-15);
}

TEST(Binning, of_one_pixel_is_one) { EXPECT_EQ(otf_at(binning(1, 1), 123.0, 1e7).re, 1.0); }

TEST(Binning, spacing_beyond_the_output_pitch_is_warned_about) {
  auto c = binning(2, 2);
  EXPECT_TRUE(c.check(detector().context()).empty());
  set(c, "spacing", 17.0, "um");  // the output's own pitch
  ASSERT_EQ(c.check(detector().context()).size(), 1u);
  EXPECT_FALSE(c.check(detector().context())[0].error);
  EXPECT_TRUE(refused(binning(0, 1), "columns"));
}

}  // namespace
}  // namespace mtf::test
