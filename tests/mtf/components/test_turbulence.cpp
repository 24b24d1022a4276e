// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "mtf/components/turbulence.h"
#include "tests/mtf/components/one_component.h"
#include "tests/mtf/reference_table.h"

namespace mtf::test {
namespace {

Component<double> turbulence(double r0_mm, bool is_short = false, double alpha = 0.5, int constant = 0) {
  auto c = Component<double>::make("turbulence");
  set(c, "fried_parameter", r0_mm);
  choose(c, "exposure", is_short ? 1 : 0);
  if (is_short) set(c, "alpha", alpha);
  choose(c, "constant", constant);
  return c;
}

// 4 um, D 0.1 m (100 mm focal length, F/1), r0 0.05 m; u = 2000, 5000, 10000 cy/rad.
TEST(Turbulence, ten_digits) {
  const std::array f{20.0, 50.0, 100.0};
  const std::array<std::array<double, 3>, 4> values{{{.8501804224, .4735827119, .0932064635},
                                                     {.8804353535, .5892650349, .2234114147},
                                                     {.8502581456, .4737821187, .0933311174},
                                                     {.8804985011, .5894405906, .2236000827}}};
  for (std::size_t row = 0; row < 4; ++row)
    for (std::size_t i = 0; i < 3; ++i)
      EXPECT_NEAR(otf_at(turbulence(50.0, row % 2 == 1, 0.5, row < 2 ? 0 : 1), f[i], 0.0).re, values[row][i],
                  kTenDigits)
          << row << i;
}

TEST(Turbulence, against_the_tables) {
  for (const auto& [name, rows] : {std::pair{"long exposure", 42}, {"short exposure", 783}}) {
    const auto check = reference_check("turbulence", name);
    EXPECT_TRUE(check.passed) << check.failure;
    EXPECT_EQ(check.count, 2 * rows);
  }
}

// 4 ulp, and the conditioning: the exponent E of the long exposure is rounded, which e^-E turns into a relative error.
TEST(Turbulence, against_the_table_at_exact_doubles) {
  for (const Row& row : reference_table("kolmogorov.csv")) {
    const double v = number(row, "v_hex"), w = number(row, "w_hex"), alpha = number(row, "alpha_hex");
    const KolmogorovExponent e = kolmogorov_exponent(v, w, alpha);
    const long double full = kolmogorov_exponent(v, 0.0, 0.0).value, otf = precise(row, "otf");
    EXPECT_LE(std::abs(e.value - precise(row, "exponent")), 6.0L * kUlp * full) << v << " " << w << " " << alpha;
    EXPECT_LE(std::abs(std::exp(-Turbulence<double>::kExact * e.value) - otf),
              kUlp * otf * (4.0L + 2.0L * Turbulence<double>::kExact * full) + 5e-324L)
        << v << " " << w << " " << alpha;
  }
}

TEST(Turbulence, short_exposure_without_alpha_is_the_long_one) {
  for (const double f : {1.0, 30.0, 249.0, 400.0})
    EXPECT_EQ(otf_at(turbulence(50.0, true, 0.0), f, f).re, otf_at(turbulence(50.0), f, f).re) << f;
}

// D/lambda is 250 cy/mm here. Near field: rises back to 1 there, and no further.
TEST(Turbulence, short_exposure_beyond_the_aperture) {
  for (const double f : {250.0001, 300.0, 1e4, 1e300})
    EXPECT_EQ(otf_at(turbulence(80.0, true, 1.0), f, 0.0).re, 1.0) << f;
  for (const double alpha : {0.3, 0.9, 1.0})
    EXPECT_NEAR(otf_at(turbulence(80.0, true, alpha), 250.0 * (1.0 - 1e-12), 0.0).re,
                otf_at(turbulence(80.0, true, alpha), 250.0 * (1.0 + 1e-12), 0.0).re, 1e-10);
}

TEST(Turbulence, fried_parameter_scales_with_the_wavelength) {
  auto c = turbulence(50.0);
  set(c, "wavelength_reference", 0.5);
  const double r0 = 50.0 * std::pow(8.0, 1.2);
  EXPECT_NEAR(otf_at(c, 90.0, 0.0).re, otf_at(turbulence(r0), 90.0, 0.0).re, 1e-14);
}

TEST(Turbulence, aperture_comes_from_the_optics_unless_given) {
  System<double> s = detector();
  s.optics.f_number.reset();
  EXPECT_TRUE(refused(turbulence(50.0, true), "aperture", s));
  EXPECT_FALSE(refused(turbulence(50.0), "aperture", s));
  s.optics.aperture_mm = 60.0;
  auto own = turbulence(50.0, true);
  set(own, "aperture", 60.0);
  EXPECT_EQ(otf_at(turbulence(50.0, true), 40.0, 0.0, s).re, otf_at(own, 40.0, 0.0).re);
  EXPECT_NE(otf_at(own, 40.0, 0.0).re, otf_at(turbulence(50.0, true), 40.0, 0.0).re);
}

}  // namespace
}  // namespace mtf::test
