// SPDX-License-Identifier: Apache-2.0
#include <ceres/jet.h>
#include <gtest/gtest.h>

#include "radiometry/light/blackbody.h"
#include "radiometry/performance/correction_residual.h"

// One body for double and Jet: values are equal, derivatives those of the double functions.

namespace radiometry {
namespace {

using Jet = ceres::Jet<double, 3>;

TEST(RadiometryJets, blackbody) {
  const Jet w(10.0, 0), t(300.0, 1), hi(12.0, 2);
  for (const Flux flux : {Flux::watts, Flux::photons}) {
    const Jet p = planck(flux, w, t);
    EXPECT_EQ(p.a, planck(flux, 10.0, 300.0));
    EXPECT_EQ(p.v[0], planck_slopes(flux, 10.0, 300.0).by_wavelength);
    EXPECT_EQ(p.v[1], planck_derivative(flux, 10.0, 300.0));
    const Jet b = band_radiance(flux, w, hi, t);
    EXPECT_EQ(b.a, band_radiance(flux, 10.0, 12.0, 300.0));
    EXPECT_EQ(b.v[0], -planck(flux, 10.0, 300.0));
    EXPECT_EQ(b.v[1], band_derivative(flux, 10.0, 12.0, 300.0));
    EXPECT_EQ(b.v[2], planck(flux, 12.0, 300.0));
    const Jet back = brightness_temperature(flux, w, p);
    EXPECT_NEAR(back.a, 300.0, 1e-12);
    EXPECT_NEAR(back.v[0], 0.0, 1e-12);
    EXPECT_NEAR(back.v[1], 1.0, 1e-14);
  }
}

/// NETD of a camera as a function of f-number, integration time and temperature.
template <class S>
S netd(const S& f_number, const S& integration_s, const S& temperature_k) {
  Camera<S> camera{.f_number = f_number, .transmission = S(0.85)};
  Pixel<S> pixel{.width_um = S(15),
                 .height_um = S(15),
                 .quantum_efficiency = S(0.7),
                 .integration_s = integration_s,
                 .dark_e_s = S(1e5),
                 .full_well_e = S(1e7)};
  const S lo(3.0), hi(5.0);
  BandRadiances<S> radiances{.scene = band_radiance(Flux::photons, lo, hi, temperature_k)};
  const S slope = electrons_per_radiance(camera, pixel) * band_derivative(Flux::photons, lo, hi, temperature_k);
  NoiseTerms<S> noise{.read_e = S(300)};
  return make_budget(pixel, signal(camera, pixel, radiances), noise, slope).netd_k;
}

TEST(RadiometryJets, a_full_well_has_no_netd_and_no_slope_of_it) {
  const Jet full = netd(Jet(2.5, 0), Jet(0.1, 1), Jet(300.0, 2));
  EXPECT_TRUE(std::isnan(full.a));
  EXPECT_TRUE(std::isnan(netd(2.5, 0.1, 300.0)));
}

TEST(RadiometryJets, netd_against_differences) {
  const Jet n(2.5, 0), t(0.01, 1), k(300.0, 2);
  const Jet value = netd(n, t, k);
  EXPECT_EQ(value.a, netd(2.5, 0.01, 300.0));
  const double h = 1e-5;
  EXPECT_NEAR(value.v[0] * 2.5, (netd(2.5 * (1 + h), 0.01, 300.0) - netd(2.5 * (1 - h), 0.01, 300.0)) / (2 * h), 1e-9);
  EXPECT_NEAR(value.v[1] * 0.01, (netd(2.5, 0.01 * (1 + h), 300.0) - netd(2.5, 0.01 * (1 - h), 300.0)) / (2 * h), 1e-9);
  EXPECT_NEAR(value.v[2] * 300, (netd(2.5, 0.01, 300.0 * (1 + h)) - netd(2.5, 0.01, 300.0 * (1 - h))) / (2 * h), 1e-8);
  EXPECT_GT(value.v[0], 0.0);
  EXPECT_LT(value.v[1], 0.0);
}

/// Irradiance around the cone over that inside of it, by both cones.
template <class S>
S around(const S& f_number, Cone cone) {
  const Camera<S> camera{.f_number = f_number, .cone = cone};
  return around_cone_sr(camera) / irradiance(camera, S(1));
}

TEST(RadiometryJets, cones) {
  for (const Cone cone : {Cone::tangent, Cone::sine})
    for (const double n : {0.6, 2.5}) {
      const double h = 1e-5 * n;
      EXPECT_NEAR(around(Jet(n, 0), cone).v[0], (around(n + h, cone) - around(n - h, cone)) / (2 * h), 1e-7);
    }
}

/// What a correction leaves at a charge, with a dark current and a full well.
template <class S>
S residual(const S& charge_e, const S& dark_e, const S& full_well_e) {
  const FlatFrames<S> flats{.low_e = S(0.2) * full_well_e,
                            .high_e = S(0.8) * full_well_e,
                            .dark_e = dark_e,
                            .full_well_e = full_well_e,
                            .variance = S(1e5),
                            .frames = 8,
                            .response = {.a2 = -0.1, .a3 = 0.02}};
  const CorrectionResidual<S> left = correction_residual(flats, charge_e);
  return left.prnu + left.flats_e;
}

TEST(RadiometryJets, what_a_correction_leaves) {
  for (const double e : {1e6, 3e6, 1.2e7}) {  // the last one beyond the well
    const double d = 2e5, w = 7e6, h = 1e-5;
    const Jet value = residual(Jet(e, 0), Jet(d, 1), Jet(w, 2));
    EXPECT_NEAR(value.a / residual(e, d, w), 1.0, 1e-14);  // jets divide by multiplying
    EXPECT_NEAR(value.v[0], (residual(e * (1 + h), d, w) - residual(e * (1 - h), d, w)) / (2 * h * e), 1e-7);
    EXPECT_NEAR(value.v[1], (residual(e, d * (1 + h), w) - residual(e, d * (1 - h), w)) / (2 * h * d), 1e-7);
    EXPECT_NEAR(value.v[2], (residual(e, d, w * (1 + h)) - residual(e, d, w * (1 - h))) / (2 * h * w), 1e-7);
  }
}

}  // namespace
}  // namespace radiometry
