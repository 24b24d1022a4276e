// SPDX-License-Identifier: Apache-2.0
// The defocused pupil as a component: units, traps of published forms, ways to give the amount.
#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "mtf/components/pupil/defocus_pupil.h"
#include "mtf/components/pupil/pupil.h"
#include "mtf/math/special.h"
#include "tests/expect_error.h"
#include "tests/mtf/components/one_component.h"
#include "tests/mtf/reference_table.h"

namespace mtf::test {
namespace {

// Hopkins' integral at s = 2 nu, ten wavefronts and frequencies; the last places of six are rounded.
TEST(DefocusPupil, golden_values) {
  const std::array<double, 5> s{0.1, 0.2, 0.5, 1.0, 1.5};
  const std::array<double, 5> half_wave{.895521, .742089, .317332, .084609, .069899},
      one_wave{.780093, .426646, -.068308, -.020072, -.010144};
  for (std::size_t i = 0; i < s.size(); ++i) {
    EXPECT_NEAR(defocus_pupil_otf(0.5 * s[i], 0.0, 0.5).value, half_wave[i], 5.1e-7);
    EXPECT_NEAR(defocus_pupil_otf(0.5 * s[i], 0.0, 1.0).value, one_wave[i], 5.1e-7);
    EXPECT_EQ(defocus_pupil_otf(0.5 * s[i], 0.0, -1.0).value, defocus_pupil_otf(0.5 * s[i], 0.0, 1.0).value);
  }
}

TEST(DefocusPupil, against_the_tables_at_exact_doubles) {
  for (const auto& [name, count] :
       {std::pair{"clear, to 50 waves", 1666}, std::pair{"annular, to 10 waves", 2563},
        std::pair{"clear, to 50 waves, slopes", 1666 * 2}, std::pair{"annular, to 10 waves, slopes", 2563 * 3}}) {
    const auto check = reference_check("defocus", name);
    EXPECT_TRUE(check.passed) << check.failure;
    EXPECT_EQ(check.count, count);
  }
}

TEST(DefocusPupil, nothing_is_diffraction_and_derivatives_meet) {
  for (const double e : {0.0, 0.3, 0.999})
    for (const double nu : {0.0, 1e-300, 0.2, 0.5, 0.999999, 1.0, 7.0}) {
      const DefocusOtf h = defocus_pupil_otf(nu, e, 0.0);
      const PupilMtf m = annular_pupil_mtf(nu, e);
      EXPECT_EQ(h.value, m.value);
      EXPECT_EQ(h.d_nu, m.d_nu);
      EXPECT_EQ(h.d_w020, 0.0);
      // Ever less defocus comes to the same, both parts of the kernel meeting at k = 1.
      EXPECT_NEAR(defocus_pupil_otf(nu, e, 1e-9).value, m.value, 1e-16);
      if (nu > 0.0 && nu < 1.0 && nu > 1e-3) {
        const double waves = 1.0 / (8.0 * kPi * nu);
        EXPECT_NEAR(defocus_pupil_otf(nu, e, waves * (1.0 - 1e-13)).value,
                    defocus_pupil_otf(nu, e, waves * (1.0 + 1e-13)).value, 2e-13 + 2e-15 / (1.0 - e * e));
      }
    }
}

// From quadrature to the path of descent, at 24 radians of phase on an arc: no step.
TEST(DefocusPupil, continuous_where_the_method_changes) {
  for (const double e : {0.0, 0.4, 0.9})
    for (double nu = 0.05; nu < 1.0; nu += 0.0731) {
      double previous = defocus_pupil_otf(nu, e, 0.0).value;
      for (double waves = 0.0; waves < 60.0; waves += 0.05) {
        const DefocusOtf h = defocus_pupil_otf(nu, e, waves), step = defocus_pupil_otf(nu, e, waves + 1e-9);
        EXPECT_NEAR(step.value - h.value, 1e-9 * h.d_w020, 1e-13) << e << " " << nu << " " << waves;
        EXPECT_LE(std::abs(h.value - previous), 0.05 * 8.0 * kPi * nu);
        previous = h.value;
      }
    }
}

TEST(DefocusPupil, huge_amounts_stay_finite_and_small) {
  for (const double waves : {1e3, 1e6, 1e12, 1e300})
    for (const double nu : {1e-300, 1e-9, 0.1, 0.5, 0.99}) {
      const DefocusOtf h = defocus_pupil_otf(nu, 0.3, waves);
      EXPECT_TRUE(std::isfinite(h.value) && std::isfinite(h.d_nu) && std::isfinite(h.d_w020)) << waves << " " << nu;
      EXPECT_LE(std::abs(h.value), 1.0);
    }
}

// W020 = dz / (8 N^2 lambda): 64 um at F/2 and 4 um are half a wave.
TEST(Defocus, distance_and_waves) {
  System<double> s = detector();
  s.optics.f_number = 2.0;
  auto by_distance = Component<double>::make("defocus"), by_waves = by_distance;
  set(by_distance, "distance", 64.0);
  set(by_waves, "waves", 0.5);
  for (const double f : {3.0, 20.0, 61.0, 124.0})
    EXPECT_NEAR(otf_at(by_distance, f, 0.3 * f, s).re, otf_at(by_waves, f, 0.3 * f, s).re, 1e-15);
  EXPECT_NEAR(otf_at(by_waves, 0.1 * 62.5, 0.0, s).re, .895521, 5.1e-7);
  EXPECT_TRUE(refused(Component<double>::make("defocus"), "waves", s));
  set(by_distance, "waves", 0.5);
  EXPECT_TRUE(refused(by_distance, "waves", s));
  s.optics.obscuration = 0.9999;
  EXPECT_TRUE(refused(by_waves, "obscuration", s));
}

// A lens of F = 100 mm images 1:1 what is 200 mm before it, at 200 mm and so at twice its F/#; nothing from 100 mm on.
TEST(Defocus, a_near_focus) {
  System<double> s = detector();
  s.frame.focal_length_mm = 100.0;
  s.optics.f_number = 2.0;
  const auto said = [&](double focus_m) {
    System<double> focused = s;
    auto component = Component<double>::make("defocus");
    set(component, "focus", focus_m);
    focused.add(Stage::presample, component);
    std::vector<System<double>::Finding> found = focused.check();
    std::erase_if(found, [](const auto& one) { return one.where != "presample[0].focus"; });
    return found;
  };
  for (const double within : {0.05, 0.1}) {
    ASSERT_EQ(said(within).size(), 1U);
    EXPECT_TRUE(said(within)[0].problem.error);
    expect_says(said(within)[0].problem.text, {"focal length of 0.1 m", "focus farther"});
  }
  ASSERT_EQ(said(0.2).size(), 1U);
  EXPECT_FALSE(said(0.2)[0].problem.error);
  expect_says(said(0.2)[0].problem.text, {"are 2 times", "f_number"});
  EXPECT_TRUE(said(20.0).empty());
}

}  // namespace
}  // namespace mtf::test
