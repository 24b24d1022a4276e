// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "mtf/math/special.h"
#include "tests/mtf/components/one_component.h"

namespace mtf::test {
namespace {

Component<double> intensifier(double frequency_cy_mm, double index) {
  auto c = Component<double>::make("image_intensifier");
  set(c, "frequency", frequency_cy_mm, "cy/mm");
  set(c, "index", index);
  return c;
}

// exp(-u^n) with 30 digits by mpmath.
TEST(ImageIntensifier, ValuesOfJohnsonsForm) {
  struct {
    double u, index, value;
  } const table[] = {{0.5, 1.1, 0.627183262875473070},
                     {1.0, 1.6, 0.367879441171442322},
                     {2.0, 1.7, 0.0388126293957926880},
                     {0.1, 2.1, 0.992088182154390403},
                     {0.01, 1.1, 0.993710290114905854}};
  for (const auto& row : table) {
    EXPECT_NEAR(otf_at(intensifier(25.0, row.index), 25.0 * row.u, 0.0).re, row.value, 4e-16) << row.index;
    EXPECT_NEAR(otf_at(intensifier(25.0, row.index), 15.0 * row.u, -20.0 * row.u).re, row.value, 4e-16) << row.index;
  }
}

// An index of 2 is a Gaussian with a standard deviation of 1/(sqrt(2) pi f0), one of 1 the Lorentz halo of width
// 1/(2 pi f0) that holds all the light.
TEST(ImageIntensifier, IsAGaussianOrALorentzHaloAtWholeIndices) {
  const double f0 = 18.0;
  auto gaussian = Component<double>::make("gaussian");
  set(gaussian, "sigma", 1e3 / (std::sqrt(2.0) * kPi * f0), "um");
  auto halo = Component<double>::make("halo");
  set(halo, "fraction", 1.0);
  set(halo, "width", 1e3 / (2.0 * kPi * f0), "um");
  choose(halo, "profile", 2);
  for (const double fx : {0.0, 1.0, 7.0, 30.0, 55.0})
    for (const double fy : {0.0, -12.0, 40.0}) {
      EXPECT_NEAR(otf_at(intensifier(f0, 2.0), fx, fy).re, otf_at(gaussian, fx, fy).re, 1e-15) << fx << ' ' << fy;
      EXPECT_NEAR(otf_at(intensifier(f0, 1.0), fx, fy).re, otf_at(halo, fx, fy).re, 1e-15) << fx << ' ' << fy;
    }
}

TEST(ImageIntensifier, FarFrequenciesVanishWithoutOverflow) {
  EXPECT_EQ(otf_at(intensifier(1e-9, 4.0), 1e300, 1e300).re, 0.0);
  EXPECT_EQ(otf_at(intensifier(1e9, 4.0), 1e-300, 0.0).re, 1.0);
  EXPECT_TRUE(refused(intensifier(25.0, 0.9), "index"));
  EXPECT_TRUE(refused(intensifier(0.0, 1.5), "frequency"));
}

}  // namespace
}  // namespace mtf::test
