// SPDX-License-Identifier: Apache-2.0
#include <ceres/jet.h>
#include <gtest/gtest.h>

#include "radiometry/blackbody.h"

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

}  // namespace
}  // namespace radiometry
