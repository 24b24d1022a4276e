// SPDX-License-Identifier: Apache-2.0
#include "radiometry/performance/giqe.h"

#include <gtest/gtest.h>

#include "radiometry/performance/giqe.h"
#include "tests/expect_error.h"
#include "tests/radiometry/performance_cases.h"

namespace radiometry {
namespace {

using test::performance_cases;

constexpr double kInfinite = std::numeric_limits<double>::infinity();
constexpr Giqe4Input<double> kSharpened{
    .gsd_m = 0.5, .rer = 0.9, .overshoot = 1.2, .noise_gain = 2.0, .snr = 50.0, .elevation_deg = 60.0};

// Values that pyBSM 0.14 gives for these arguments.
TEST(Giqe, equals_pybsm_where_the_constants_do) {
  EXPECT_NEAR(niirs_giqe3(kSharpened), 5.545552656, 1e-9);
  const Giqe5Input<double> in{.gsd_m = 0.5, .rer_x = 0.5, .rer_y = 0.4, .snr = 50.0, .elevation_deg = 60.0};
  EXPECT_NEAR(niirs_giqe5(in), 5.104608550, 1e-9);
  // GIQE 4: 0.334 there, 0.344 in print; 0.01 G/SNR is all of the difference.
  EXPECT_NEAR(niirs_giqe4(kSharpened), 4.978872446 - 0.01 * 2.0 / 50.0, 1e-9);
}

// Figure 1 of the document of GIQE 5: RER 0.35, 20.8 in, SNR 50 is NIIRS 5.
TEST(Giqe, case_in_print) {
  const Giqe5Input<double> in{.gsd_m = 20.8 * 0.0254, .rer_x = 0.35, .rer_y = 0.35, .snr = 50.0};
  EXPECT_NEAR(niirs_giqe5(in), 5.015, 5e-4);
}

TEST(Giqe, against_40_digits) {
  const auto giqe4 = [](const std::vector<double>& x) {
    return Giqe4Input<double>{.gsd_m = x[1],
                              .rer = x[0],
                              .overshoot = x[2],
                              .noise_gain = x[3],
                              .snr = x[4],
                              .elevation_deg = x.size() > 5 ? x[5] : 90.0};
  };
  for (const auto& c : performance_cases("niirs3")) EXPECT_NEAR(niirs_giqe3(giqe4(c.x)), c.value, 1e-14) << c.where;
  for (const auto& c : performance_cases("niirs4")) EXPECT_NEAR(niirs_giqe4(giqe4(c.x)), c.value, 1e-14) << c.where;
  for (const auto& c : performance_cases("niirs5")) {
    const Giqe5Input<double> in{
        .gsd_m = c.x[2], .rer_x = c.x[0], .rer_y = c.x[1], .snr = c.x[3], .elevation_deg = c.x[4]};
    EXPECT_NEAR(niirs_giqe5(in), c.value, 1e-14) << c.where;
  }
}

TEST(Giqe, noise_and_sharpness_at_their_limits) {
  Giqe4Input<double> quiet = kSharpened;
  quiet.snr = kInfinite;
  EXPECT_NEAR(niirs_giqe3(quiet) - niirs_giqe3(kSharpened), 2.0 / 50.0, 1e-14);
  EXPECT_NEAR(niirs_giqe4(quiet) - niirs_giqe4(kSharpened), 0.344 * 2.0 / 50.0, 1e-14);
  // Without noise the sharpness counts in GIQE 5 by the fourth power of its logarithm alone; 1 inch, RER 0.1: 9.57 - 2.
  const Giqe5Input<double> five{.gsd_m = 0.0254, .rer_x = 0.1, .rer_y = 0.1, .snr = kInfinite};
  EXPECT_NEAR(niirs_giqe5(five), 7.57, 1e-14);
  // An image that is all noise counts for less with each bit of it, without an end, but never as NaN.
  EXPECT_LT(niirs_giqe5(Giqe5Input<double>{.gsd_m = 0.5, .rer_x = 0.5, .rer_y = 0.5, .snr = 1e-3}), -1000.0);
}

// GSD 1 inch: the jump at RER 0.9 is that of the terms in RER alone, (2.817 - 1.559) log10 0.9 = -0.05756.
TEST(Giqe, version_4_jumps_at_0_9) {
  Giqe4Input<double> in{.gsd_m = 0.0254, .rer = 0.9, .snr = kInfinite};
  const double above = niirs_giqe4(in);
  in.rer = std::nextafter(0.9, 0.0);
  EXPECT_NEAR(niirs_giqe4(in) - above, 1.258 * std::log10(0.9), 1e-13);
}

TEST(Giqe, larger_samples_blur_noise_and_slant_cost) {
  double before = 1e9;
  for (const double gsd : {0.05, 0.1, 0.5, 2.0, 30.0}) {
    const double now = niirs_giqe5(Giqe5Input<double>{.gsd_m = gsd, .rer_x = 0.4, .rer_y = 0.4, .snr = 30.0});
    EXPECT_NEAR(now,
                niirs_giqe5(Giqe5Input<double>{.gsd_m = 2 * gsd, .rer_x = 0.4, .rer_y = 0.4, .snr = 30.0}) +
                    3.32 * std::log10(2.0),
                1e-13);
    EXPECT_LT(now, before);
    before = now;
  }
  for (const double elevation : {90.0, 60.0, 20.0, 1.0}) {
    Giqe4Input<double> in = kSharpened;
    in.elevation_deg = elevation;
    const double now = niirs_giqe4(in);
    EXPECT_NEAR(now, niirs_giqe4([&] {
                  Giqe4Input<double> ground = kSharpened;
                  ground.elevation_deg = 90.0;
                  ground.gsd_m /= std::sqrt(std::sin(elevation * mtf::kPi / 180.0));
                  return ground;
                }()),
                1e-13);
  }
  // The smaller of the two RER counts twice.
  const Giqe5Input<double> in{.gsd_m = 0.5, .rer_x = 0.8, .rer_y = 0.1, .snr = 10.0};
  const double mean = std::cbrt(0.8 * 0.1 * 0.1);
  EXPECT_NEAR(
      niirs_giqe5(in),
      niirs_giqe5(Giqe5Input<double>{.gsd_m = 0.5, .rer_x = mean, .rer_y = mean, .snr = 10.0, .elevation_deg = 90}),
      1e-13);
}

TEST(Giqe, refuses_by_name) {
  expect_refused({"giqe5.gsd", "giqe5.rer_y", "giqe5.snr", "giqe5.elevation"}, [] {
    niirs_giqe5(Giqe5Input<double>{.gsd_m = 0.0, .rer_x = 0.5, .rer_y = -0.1, .snr = 0.0, .elevation_deg = 91.0});
  });
  expect_refused({"giqe4.overshoot", "giqe4.noise_gain"}, [] {
    Giqe4Input<double> in = kSharpened;
    in.overshoot = -1.0;
    in.noise_gain = std::nan("");
    niirs_giqe4(in);
  });
  expect_refused({"giqe3.rer"}, [] { niirs_giqe3(Giqe4Input<double>{.gsd_m = 1.0, .snr = 1.0}); });
}

TEST(GroundResolution, gsd) { EXPECT_NEAR(ground_sample_distance_m(8.0, 4000.0, 9000.0), 0.018, 1e-17); }

TEST(GroundResolution, closed_forms_of_a_gaussian) {
  using Limit = GroundResolution<double>::Limit;
  for (const auto& c : performance_cases("grd")) {
    const auto r = ground_resolved_distance(GrdInput<double>{.snr = c.x[1], .ifov_mrad = c.x[2], .range_m = c.x[3]},
                                            [&](double f) { return test::gaussian_mtf(f, c.x[0]); });
    EXPECT_NEAR(r.grd_m, c.value, 1e-11 * c.value) << c.where;
    EXPECT_EQ(r.limit, c.x[2] < 0.5 ? Limit::contrast : Limit::sampling);
  }
}

TEST(GroundResolution, limits) {
  using Limit = GroundResolution<double>::Limit;
  const auto flat = [](double) { return 1.0; };
  GrdInput<double> in{.snr = kInfinite, .ifov_mrad = 0.1, .range_m = 1000.0};
  EXPECT_EQ(ground_resolved_distance(in, flat).limit, Limit::sampling);
  EXPECT_NEAR(ground_resolved_distance(in, flat).grd_m, 2.0 * 0.1, 1e-15);  // 2 GSD
  in.snr = 3.0;
  EXPECT_EQ(ground_resolved_distance(in, flat).limit, Limit::none);
  EXPECT_EQ(ground_resolved_distance(in, flat).grd_m, kInfinite);
  // An MTF that rises again beyond its zero: the first fall counts, at 1 cycle/mrad.
  in.snr = 30.0;
  const auto back = [](double f) { return f < 2.0 ? 1.9 - 1.8 * f : 0.5; };
  EXPECT_NEAR(ground_resolved_distance(in, [&](double f) { return f < 0.5 ? 1.0 : back(f); }).grd_m, 1.0, 1e-12);
  expect_refused({"grd.ifov"}, [&] {
    ground_resolved_distance(GrdInput<double>{.snr = 5.0, .ifov_mrad = 0.0, .range_m = 1.0}, flat);
  });
}

TEST(GroundResolution, more_noise_resolves_less) {
  double before = 0.0;
  for (const double snr : {1e6, 300.0, 30.0, 6.0, 3.1}) {
    const GrdInput<double> in{.snr = snr, .ifov_mrad = 0.01, .range_m = 1000.0};
    const double now = ground_resolved_distance(in, [](double f) { return test::gaussian_mtf(f, 5.0); }).grd_m;
    EXPECT_GT(now, before);
    before = now;
  }
}

}  // namespace
}  // namespace radiometry
