// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "mtf/math/special.h"
#include "tests/mtf/components/one_component.h"

namespace mtf::test {
namespace {

Component<double> halo(int profile, double fraction, double width_um) {
  auto c = Component<double>::make("halo");
  set(c, "fraction", fraction);
  set(c, "width", width_um, "um");
  choose(c, "profile", profile);
  return c;
}

/// Integral from 0 to `end` by the rule of Simpson.
double integral(double end, int intervals, const std::function<double(double)>& f) {
  const double h = end / intervals;
  double sum = f(0.0) + f(end);
  for (int i = 1; i < intervals; ++i) sum += (i % 2 == 1 ? 4.0 : 2.0) * f(h * i);
  return sum * h / 3.0;
}

// The transform of the point spread of each profile, by quadrature: of r psf(r) J0(2 pi f r) over that of r psf(r).
TEST(Halo, is_the_transform_of_its_point_spread) {
  const double w = 0.1;  // mm
  const auto gaussian_psf = [&](double r) { return std::exp(-0.5 * r * r / (w * w)); };
  const auto exponential_psf = [&](double r) { return std::exp(-r / w); };
  const std::function<double(double)> psf[] = {gaussian_psf, exponential_psf};
  for (int profile = 0; profile < 2; ++profile)
    for (const double f : {0.3, 1.0, 2.5, 6.0}) {
      const auto weighted = [&](double r) { return r * psf[profile](r) * ::j0(2.0 * kPi * f * r); };
      const auto weight = [&](double r) { return r * psf[profile](r); };
      const double g = integral(5.0, 40000, weighted) / integral(5.0, 40000, weight);
      EXPECT_NEAR(otf_at(halo(profile, 0.4, 1000.0 * w), f, 0.0).re, 0.6 + 0.4 * g, 1e-9) << profile << ' ' << f;
    }
  // The Lorentz halo falls too slowly for that: the other way, its point spread from the OTF.
  for (const double r : {0.0, 0.05, 0.1, 0.3}) {
    const auto component = halo(2, 1.0, 1000.0 * w);
    const double back = integral(
        80.0, 160000, [&](double f) { return 2.0 * kPi * f * otf_at(component, f, 0.0).re * ::j0(2.0 * kPi * f * r); });
    EXPECT_NEAR(back * 2.0 * kPi * w * w, std::pow(1.0 + r * r / (w * w), -1.5), 1e-6) << r;
  }
}

TEST(Halo, core_is_untouched_and_the_rest_gone_beyond_its_width) {
  for (int profile = 0; profile < 3; ++profile) {
    EXPECT_EQ(otf_at(halo(profile, 0.07, 200.0), 0.0, 0.0).re, 1.0);
    EXPECT_NEAR(otf_at(halo(profile, 0.07, 200.0), 100.0, 0.0).re, 0.93, 1e-7);
    EXPECT_EQ(otf_at(halo(profile, 0.0, 200.0), 3.0, 4.0).re, 1.0);
    // Radial: 3, 4, 5.
    EXPECT_NEAR(otf_at(halo(profile, 0.5, 60.0), 3.0, 4.0).re, otf_at(halo(profile, 0.5, 60.0), 5.0, 0.0).re, 1e-15);
  }
}

TEST(Halo, widths_per_axis) {
  auto c = halo(1, 0.5, 30.0);
  const Unit* um = find_unit("um");
  for (const FieldRef<double>& field : c.fields())
    if (field.info->name == "width") *std::get<AxisPair<double>*>(field.value) = {{30.0, um}, {60.0, um}, true};
  EXPECT_NEAR(otf_at(c, 8.0, 0.0).re, otf_at(c, 0.0, 4.0).re, 1e-15);
  EXPECT_FALSE(c.traits(detector().context()).radial);
  EXPECT_FALSE(c.traits(detector().context()).separable);
}

}  // namespace
}  // namespace mtf::test
