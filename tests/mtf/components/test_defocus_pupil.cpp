// SPDX-License-Identifier: Apache-2.0
// The defocused pupil against 30-digit tables at exact doubles, up to 50 waves.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <iostream>

#include "mtf/components/defocus_pupil.h"
#include "mtf/special.h"
#include "tests/mtf/reference_table.h"

namespace mtf::test {
namespace {

long double compare(const Row& row, double obscuration) {
  const double w020 = number(row, "w020_hex"), nu = number(row, "nu_hex"), k = 8.0 * kPi * w020 * nu;
  const DefocusOtf h = defocus_pupil_otf(nu, obscuration, w020);
  const double ring = (1.0 - obscuration) * (1.0 + obscuration);
  const long double error = std::abs(h.value - precise(row, "otf"));
  const auto where = [&] {
    return "e = " + std::to_string(obscuration) + ", W020 = " + row.at("w020_hex") + ", nu = " + row.at("nu_hex");
  };
  EXPECT_LE(error, w020 <= 3.0 ? 1e-12L : 1e-10L) << where();
  EXPECT_LE(error, 2e-15L * (1.0 + k / 8.0) / ring) << where();
  // Slopes are larger by the phase or the waves, and lose another width of the ring.
  const long double slope = 1e-14L * (1.0 + k + w020) / (ring * ring);
  EXPECT_LE(std::abs(h.d_nu - precise(row, "d_nu")), slope) << where();
  EXPECT_LE(std::abs(h.d_w020 - precise(row, "d_w020")), slope) << where();
  if (obscuration > 0.0) {
    EXPECT_LE(std::abs(h.d_obscuration - precise(row, "d_obscuration")), slope) << where();
  }
  return error;
}

TEST(DefocusPupil, clear_against_the_table) {
  long double worst = 0.0L;
  for (const Row& row : reference_table("defocus_circular.csv")) worst = std::max(worst, compare(row, 0.0));
  std::cout << "defocus of a clear pupil, up to 50 waves: largest error " << worst << "\n";
}

TEST(DefocusPupil, annular_against_the_table) {
  long double worst = 0.0L;
  for (const Row& row : reference_table("defocus_annular.csv"))
    worst = std::max(worst, compare(row, number(row, "obscuration_hex")));
  std::cout << "defocus of annular pupils, up to 10 waves: largest error " << worst << "\n";
}

}  // namespace
}  // namespace mtf::test
