// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>

#include "radiometry/light/curve_gaps.h"
#include "radiometry/light/spectrum.h"
#include "tests/expect_error.h"

namespace radiometry {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

TEST(Spectrum, lines_between_samples_zero_outside) {
  const Spectrum s = make_spectrum("qe", {3.0, 4.0, 5.0}, {0.2, 0.6, 0.0});
  EXPECT_EQ(evaluate(s, 2.999), 0.0);
  EXPECT_EQ(evaluate(s, 3.0), 0.2);
  EXPECT_NEAR(evaluate(s, 3.5), 0.4, 1e-16);
  EXPECT_EQ(evaluate(s, 4.0), 0.6);
  EXPECT_NEAR(evaluate(s, 4.75), 0.15, 1e-16);
  EXPECT_EQ(evaluate(s, 5.0), 0.0);
  EXPECT_EQ(evaluate(s, 5.1), 0.0);
}

TEST(Spectrum, one_sample_is_a_constant) {
  const Spectrum s = make_spectrum("filter", {4.0}, {0.8});
  for (const double w : {1e-3, 4.0, 1e6}) EXPECT_EQ(evaluate(s, w), 0.8);
  const Interval common = common_range({8.0, 12.0}, {&s, 1});
  EXPECT_EQ(common.lo_um, 8.0);
  EXPECT_EQ(common.hi_um, 12.0);
  EXPECT_EQ(product("both", std::vector{s, s}).value, std::vector<double>{0.8 * 0.8});
}

TEST(Spectrum, product_lies_on_the_union_of_the_grids) {
  const std::vector curves{make_spectrum("a", {1.0, 3.0, 6.0}, {0.0, 1.0, 0.5}),
                           make_spectrum("b", {2.0, 3.0, 4.0, 7.0}, {1.0, 0.5, 0.5, 0.2}), constant_spectrum("c", 0.5)};
  const Spectrum p = product("p", curves);
  EXPECT_EQ(p.wavelength_um, (std::vector{2.0, 3.0, 4.0, 6.0}));
  for (std::size_t i = 0; i < p.value.size(); ++i)
    EXPECT_EQ(p.value[i], evaluate(curves[0], p.wavelength_um[i]) * evaluate(curves[1], p.wavelength_um[i]) * 0.5);
}

TEST(Spectrum, a_curve_that_stops_inside_the_open_range_says_what_counts_as_0) {
  const Spectrum tau = make_spectrum("tau.csv", {3.5, 4.2}, {0.8, 0.9});
  expect_says(missing_words(tau, {3.5, 5.0}),
              {"tau.csv: covers 3.5 um to 4.2 um", "4.2 um to 5 um of the band", "0.9"});
  expect_says(missing_words(tau, {3.0, 5.0}), {"3 um to 3.5 um and 4.2 um to 5 um", "0.8 and 0.9"});
  EXPECT_EQ(missing_words(tau, {3.5, 4.2}), "");
  EXPECT_EQ(missing_words(tau, {3.6, 4.0}), "");
  EXPECT_EQ(missing_words(constant_spectrum("qe", 0.7), {3.0, 5.0}), "");
  // Below 1 % of the largest value a curve has come down.
  for (const double last : {0.0, 0.0089, 0.0091}) {
    const Spectrum cut = make_spectrum("cut.csv", {3.0, 4.0, 4.5}, {0.9, 0.9, last});
    EXPECT_EQ(missing_words(cut, {3.0, 5.0}).empty(), last < 0.009) << last;
    EXPECT_EQ(open_range({3.0, 5.0}, {&cut, 1}).hi_um, last < 0.009 ? 4.5 : 5.0) << last;
  }
  // Where the filter is shut nothing is missing of the others.
  const Spectrum filter = make_spectrum("filter", {3.0, 3.4, 3.5, 4.8, 4.9, 5.0}, {0.0, 0.0, 0.8, 0.8, 0.0, 0.0});
  const Interval open = open_range({2.0, 6.0}, {&filter, 1});
  EXPECT_EQ(open.lo_um, 3.4);
  EXPECT_EQ(open.hi_um, 4.9);
  EXPECT_EQ(missing_words(filter, open), "");
  EXPECT_EQ(missing_words(make_spectrum("qe", {3.4, 4.9}, {0.7, 0.7}), open), "");
  expect_says(missing_words(make_spectrum("qe", {3.6, 5.0}, {0.7, 0.7}), open), {"3.4 um to 3.6 um of the band"});
}

TEST(Spectrum, refusals_say_where_and_what) {
  expect_refused({"qe.csv", "3 wavelengths and 2 values"}, [] { make_spectrum("qe.csv", {1, 2, 3}, {1, 2}); });
  expect_refused({"qe.csv", "no samples"}, [] { make_spectrum("qe.csv", {}, {}); });
  expect_refused({"qe.csv", "sample 3", "1.5 um after 2 um"}, [] { make_spectrum("qe.csv", {1, 2, 1.5}, {0, 0, 0}); });
  expect_refused({"sample 2", "after"}, [] { make_spectrum("qe.csv", {1, 1}, {0, 0}); });
  expect_refused({"sample 1", "above 0"}, [] { make_spectrum("qe.csv", {0, 1}, {0, 0}); });
  expect_refused({"sample 2", "not finite"}, [] { make_spectrum("qe.csv", {1, 2}, {0, kNan}); });
  expect_refused({"sample 2"}, [] { make_spectrum("qe.csv", {1, kNan}, {0, 0}); });
  expect_refused({"sample 1", "-0.5", "negative"}, [] { make_spectrum("qe.csv", {1, 2}, {-0.5, 0}); });
  expect_refused({"sample 2", "above 1", "percent"}, [] { make_spectrum("qe.csv", {1, 2}, {0.5, 75}, 1.0); });
  expect_refused({"sample 1", "1e+300"}, [] { make_spectrum("qe.csv", {1e300}, {0}); });
  const Spectrum hollow{.source = "hollow", .wavelength_um = {}, .value = {}};
  expect_refused({"hollow", "0 values", "make_spectrum"}, [&] { common_range({3, 5}, {&hollow, 1}); });
  const Spectrum s = make_spectrum("qe.csv", {3, 5}, {1, 1});
  expect_refused({"qe.csv", "3 um to 5 um", "8 um to 12 um"}, [&] { common_range({8, 12}, {&s, 1}); });
  expect_refused({"band 12 um to 8 um"}, [&] { common_range({12, 8}, {&s, 1}); });
}

}  // namespace
}  // namespace radiometry
