// SPDX-License-Identifier: Apache-2.0
// The diffraction MTF against 30-digit tables, and against the pupil's autocorrelation by quadrature.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <set>

#include "mtf/components/pupil/pupil.h"
#include "mtf/math/special.h"
#include "tests/mtf/builders.h"
#include "tests/mtf/conformance.h"
#include "tests/mtf/reference_table.h"

namespace mtf::test {
namespace {

TEST(Pupil, circular_against_the_table) {
  const auto check = reference_check("diffraction", "circular");
  EXPECT_TRUE(check.passed) << check.failure;
  EXPECT_EQ(check.count, 2 * 90);
}

TEST(Pupil, annular_against_the_table) {
  for (const char* name : {"annular", "annular, slopes"}) {
    const auto check = reference_check("diffraction", name);
    EXPECT_TRUE(check.passed) << check.failure;
  }
  std::set<double> obscurations;
  for (const Row& row : reference_table("annular_diffraction_mtf.csv"))
    obscurations.insert(number(row, "obscuration_hex"));
  EXPECT_EQ(obscurations.size(), 18u);
  EXPECT_TRUE(obscurations.contains(0.0) && obscurations.contains(1e-6) && obscurations.contains(0.999));
}

// Printed values of O'Neill's function for a linear obscuration of 0.4, to all digits given.
TEST(Pupil, published_values_of_an_obscured_pupil) {
  const std::array<std::array<double, 2>, 4> values{
      {{0.05, 0.894007}, {0.2, 0.582881}, {0.5, 0.291236}, {0.7, 0.223953}}};
  for (const auto& [nu, mtf] : values) EXPECT_NEAR(annular_pupil_mtf(nu, 0.4).value, mtf, 5e-7);
  EXPECT_NEAR(annular_pupil_mtf(0.3, 0.4).value, 0.389, 5e-4);  // (1 - e)/2, where a careless acos jumps to 0.770
}

// Each form of the kernel takes over at a point where circles touch; there the textbook form divides 0 by 0.
TEST(Pupil, continuous_where_circles_touch) {
  for (const double e : {1e-6, 1e-3, 0.1, 0.2, 0.3, 1.0 / 3.0, 0.4, 0.5, 0.7, 0.9, 0.99, 0.999, 0.9999999})
    for (const double touch : {0.5 * (1.0 - e), 0.5 * (1.0 + e), e, 1.0}) {
      const PupilMtf at = annular_pupil_mtf(touch, e);
      EXPECT_TRUE(std::isfinite(at.value) && std::isfinite(at.d_nu) && std::isfinite(at.d_obscuration)) << e;
      EXPECT_GE(at.value, 0.0);
      for (const double step : {1e-15, 1e-12, 1e-9}) {
        // The slope itself jumps by no more than a root of the step, over the width of the ring.
        const double allowed = (4.0 * step + 8.0 * step * std::sqrt(step) / e) / ((1.0 - e) * (1.0 + e)) + 4e-15;
        for (const double side : {-step, step})
          EXPECT_NEAR(annular_pupil_mtf(touch + side, e).value, at.value, allowed) << e << " " << touch << " " << side;
      }
    }
}

// The component forms nu = f lambda N from four factors, one of them the unit's: a relative 4 x 2^-53 of conditioning
// times the slope is all that comes on top of the kernel. At every frequency of a grid of 1501 out to the cutoff, where
// for (1 - e)/2 on the grid other codes have isolated wrong samples (up to an MTF above 1).
TEST(Pupil, component_adds_the_conditioning_of_nu_alone) {
  for (const double e : {0.0, 0.2, 0.4, 0.6, 0.7, 0.8, 0.99})
    for (const double aperture_m : {0.1, 0.273, 0.275, 2.4})
      for (const double wavelength_um : {0.5, 0.55, 0.58, 10.0}) {
        System<double> system = mwir();
        system.frame.focal_length_mm = 4000.0;
        system.optics.f_number = 4.0 / aperture_m;
        system.optics.wavelength_um = wavelength_um;
        system.optics.obscuration = e;
        const auto component = Component<double>::make("diffraction");
        const double cutoff = component.cutoff_cy_mm(system.context());
        for (int k = 0; k <= 750; ++k) {
          const double f = -cutoff + (750 + k) * (2.0 * cutoff / 1500.0);
          const long double nu = static_cast<long double>(f) * wavelength_um * *system.optics.f_number / 1000.0L;
          const double rounded = static_cast<double>(nu);
          const PupilMtf m = annular_pupil_mtf(rounded, e);
          const long double exact = m.value + m.d_nu * (nu - rounded);  // the rest of nu is below 2^-53
          const double conditioning = 4.0 * 0x1p-53 * rounded * std::abs(m.d_nu);
          EXPECT_NEAR(component.otf({f, 0.0}, system.context()).re, static_cast<double>(exact), 2e-15 + conditioning)
              << "e = " << e << ", nu = " << rounded;
        }
      }
}

TEST(Pupil, vanishing_obscuration_is_the_clear_pupil) {
  for (double nu = 0.01; nu < 1.0; nu += 0.0173) {
    const PupilMtf m = annular_pupil_mtf(nu, 1e-9);
    EXPECT_NEAR(m.value, circular_pupil_mtf(nu).value, 1e-15);
    EXPECT_NEAR(m.d_nu, circular_pupil_mtf(nu).slope, 1e-8);
  }
}

// Second route: overlap of two rings by summing chords across the line of centres. At height y the pupil is
// [-outer, -inner] and [inner, outer]; the overlap of that set with itself moved by d is a sum of interval overlaps.
double chord_overlap(double y, double e, double d) {
  const double outer = std::sqrt(std::max(1.0 - y * y, 0.0)), inner = std::sqrt(std::max(e * e - y * y, 0.0));
  using Interval = std::array<double, 2>;
  const std::array<Interval, 2> pieces{{{-outer, -inner}, {inner, outer}}};
  double length = 0.0;
  for (const Interval& a : pieces)
    for (const Interval& b : pieces) length += std::max(0.0, std::min(a[1], b[1] + d) - std::max(a[0], b[0] + d));
  return length;
}

// Between the breakpoints the integrand has square-root ends only: y = middle + half sin(t) makes it smooth there.
double autocorrelation(double nu, double e) {
  const double d = 2.0 * nu;
  std::vector<double> breaks{0.0, 1.0};
  const auto add = [&](double square) {
    if (square > 0.0 && square < 1.0) breaks.push_back(std::sqrt(square));
  };
  add(e * e);
  add(1.0 - nu * nu);    // two outer circles
  add(e * e - nu * nu);  // two holes
  const double along = (d * d + 1.0 - e * e) / (2.0 * d);
  add(1.0 - along * along);  // an outer circle and a hole
  std::sort(breaks.begin(), breaks.end());
  const WavelengthNodes rule = wavelength_nodes({1.0, 3.0}, 200);  // Gauss-Legendre on [1, 3], weights sum to 1
  double area = 0.0;
  for (std::size_t i = 0; i + 1 < breaks.size(); ++i) {
    const double middle = 0.5 * (breaks[i] + breaks[i + 1]), half = 0.5 * (breaks[i + 1] - breaks[i]);
    for (std::size_t k = 0; k < rule.weight.size(); ++k) {
      const double t = 0.5 * kPi * (rule.wavelength_um[k] - 2.0);
      area += kPi * rule.weight[k] * half * std::cos(t) * chord_overlap(middle + half * std::sin(t), e, d);
    }
  }
  return 2.0 * area / (kPi * (1.0 - e * e));
}

TEST(Pupil, equals_the_autocorrelation_by_quadrature) {
  Random random(11);
  for (const double e : {0.0, 0.05, 0.25, 1.0 / 3.0, 0.5, 0.8, 0.95})
    for (int i = 0; i < 40; ++i) {
      const double nu = random.uniform(0.001, 0.999);
      EXPECT_NEAR(annular_pupil_mtf(nu, e).value, autocorrelation(nu, e), 1e-11) << e << " " << nu;
    }
}

TEST(Pupil, slopes_equal_differences) {
  Random random(12);
  for (int i = 0; i < 400; ++i) {
    const double e = random.uniform(0.02, 0.98), nu = random.uniform(0.01, 0.98), h = 1e-6 * (1.0 - e);
    const auto at = [](double v, double o) { return annular_pupil_mtf(v, o); };
    const auto value = [&](double v, double o) { return at(v, o).value; };
    // Kinks (second derivative infinite) within the step are left out.
    if (std::abs(at(nu + h, e).d_nu - at(nu - h, e).d_nu) > 1e-3) continue;
    EXPECT_NEAR(at(nu, e).d_nu, (value(nu + h, e) - value(nu - h, e)) / (2.0 * h), 2e-6 / (1.0 - e)) << e << " " << nu;
    EXPECT_NEAR(at(nu, e).d_obscuration, (value(nu, e + h) - value(nu, e - h)) / (2.0 * h), 2e-6 / (1.0 - e))
        << e << " " << nu;
  }
}

}  // namespace
}  // namespace mtf::test
