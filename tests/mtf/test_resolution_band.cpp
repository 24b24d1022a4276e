// SPDX-License-Identifier: Apache-2.0
// Figures of merit over a band, and what their series leave.

#include <gtest/gtest.h>

#include <cmath>

#include "mtf/metrics/resolution.h"
#include "tests/mtf/builders.h"

namespace mtf::test {
namespace {

// With the wavelength outside and the frequency inside, an integral that is smooth in the wavelength: each pupil cut at
// its own kinks, in double precision, the same to 2e-14 with twice as many nodes (numpy). Values of the rise from -1/2
// to 1/2 px.
TEST(Resolution, AnObscuredPupilInABandIsAsTheOtherOrderOfIntegralsSays) {
  struct Case {
    double obscuration, lo_um, hi_um, f_number, pitch_um, width_um, rer;
  };
  const std::vector<Case> cases{{0.999, 8.0, 12.0, 2.0, 12.0, 0.0, 0.00192270377237656},
                                {0.999, 8.0, 12.0, 2.0, 13.0, 0.0, 0.00206575113009712},
                                {0.0, 3.0, 5.0, 4.0, 10.0, 9.0, 0.46393781260873},
                                {0.3, 3.0, 5.0, 4.0, 10.0, 9.0, 0.413628932447167},
                                {0.97, 3.0, 5.0, 4.0, 10.0, 9.0, 0.0376427162798035}};
  for (const Case& c : cases) {
    System<double> system;
    system.frame = {100.0, c.pitch_um, c.pitch_um, 0.01, 0, 0};
    system.optics.f_number = c.f_number;
    system.optics.obscuration = c.obscuration;
    system.band = Band{c.lo_um, c.hi_um, nullptr};
    system.add(Stage::presample, Component<double>::make("diffraction"));
    if (c.width_um > 0.0) system.add(Stage::presample, footprint(c.width_um));
    ResolutionNeeds needs;
    needs.axis.edge = true;
    needs.y = false;
    for (int decade = 2; decade <= 11; ++decade) {
      needs.tolerance = std::pow(10.0, -decade);
      const Resolution<double> r = ResolutionMeter<double>(needs).measure(system);
      EXPECT_LE(std::abs(r.x.rer - c.rer), r.error + 1e-13) << c.obscuration << " at " << needs.tolerance;
      EXPECT_LE(r.error, 1.01 * needs.tolerance) << c.obscuration;
      EXPECT_LE(r.evaluations, 5000) << c.obscuration << " at " << needs.tolerance;  // some 10 ms
      EXPECT_LE(r.wavelengths, 500) << c.obscuration << " at " << needs.tolerance;
    }
  }
}

// What is left of a series is bounded for coefficients that fall by a factor, and for those of a kink.
TEST(Resolution, WhatASeriesLeavesIsBounded) {
  for (const int degree : {16, 32, 64}) {
    const auto n = static_cast<std::size_t>(degree);
    const auto bounded = [&](auto coefficient) {
      std::vector<double> known;
      for (std::size_t k = 0; k <= n; ++k) known.push_back(coefficient(static_cast<double>(k)));
      double left = 0.0;
      for (std::size_t k = n + 1; k < 2'000'000; ++k) left += coefficient(static_cast<double>(k));
      const double said = series_tail(known);
      EXPECT_GE(said, 0.95 * left) << degree;
      EXPECT_LE(said, 6.0 * left) << degree;
    };
    for (const double factor : {0.5, 0.8, 0.95}) bounded([factor](double k) { return std::pow(factor, k); });
    for (const double power : {2.5, 3.5, 4.5}) bounded([power](double k) { return std::pow(1.0 + k, -power); });
  }
}

}  // namespace
}  // namespace mtf::test
