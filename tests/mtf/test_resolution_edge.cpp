// SPDX-License-Identifier: Apache-2.0
// Edges that a phase moves.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "mtf/metrics/resolution.h"
#include "tests/mtf/builders.h"

namespace mtf::test {
namespace {

// A Gaussian behind an RC low-pass is the exponentially modified Gaussian (Grushka, Anal. Chem. 44, 1733 (1972)):
//   esf(x) = Phi(x/s) - exp(s^2/(2 t^2) - x/t) Phi(x/s - s/t)
// whose median is t ln 2 and more behind the place without the filter.
TEST(Resolution, ALongTailMovesTheEdgeAndEveryFigureIsRightOrNone) {
  constexpr double s = 0.5;
  int none = 0;
  for (const double t : {0.3, 2.0, 20.0, 150.0, 400.0, 700.0, 1400.0, 1e4, 1e7}) {
    System<double> system;
    system.frame = {100.0, 10.0, 10.0, 0.0, 0, 0};
    system.add(Stage::presample, gaussian(10.0 * s));
    auto rc = Component<double>::make("rc_lowpass");
    set(rc, "cutoff", 100.0 / (2.0 * kPi * t), "cy/mm");  // a pixel is 10 um
    system.add(Stage::presample, rc);
    ResolutionNeeds needs;
    needs.axis.edge = needs.axis.unfiltered = needs.axis.fwhm = true;
    needs.tolerance = 1e-7;
    const Resolution<double> r = ResolutionMeter<double>(needs).measure(system);
    const auto phi = [](double x) { return 0.5 * std::erfc(-x / std::numbers::sqrt2); };
    const auto esf = [&](double x) {
      return phi(x / s) - std::exp(0.5 * s * s / (t * t) - x / t) * phi(x / s - s / t);
    };
    double lo = -3.0, hi = 3.0 + 3.0 * t;
    while (0.5 * (lo + hi) > lo && 0.5 * (lo + hi) < hi) (esf(0.5 * (lo + hi)) < 0.5 ? lo : hi) = 0.5 * (lo + hi);
    none += std::isnan(r.x.rer);
    if (!std::isnan(r.x.rer)) {
      EXPECT_NEAR(r.x.rer, esf(lo + 0.5) - esf(lo - 0.5), r.error) << t;
    }
    const auto lsf = [&](double x) { return std::exp(0.5 * s * s / (t * t) - x / t) * phi(x / s - s / t) / t; };
    double peak = 0.0;
    for (double x = -3.0; x < 8.0; x += 1e-4)
      if (lsf(x) > lsf(peak)) peak = x;
    const auto half_from = [&](double inside, double outside) {
      while (std::abs(outside - inside) > 1e-10) {
        const double middle = 0.5 * (inside + outside);
        (lsf(middle) > 0.5 * lsf(peak) ? inside : outside) = middle;
      }
      return inside;
    };
    if (!std::isnan(r.x.fwhm_px)) {
      EXPECT_NEAR(r.x.fwhm_px, half_from(peak, hi + 8.0 * t) - half_from(peak, -5.0), r.error * r.x.fwhm_px) << t;
    }
    EXPECT_TRUE(t > 150.0 || !std::isnan(r.x.fwhm_px)) << t;
    EXPECT_EQ(r.edge_lost, std::isnan(r.x.rer) || std::isnan(r.x.fwhm_px)) << t;
    EXPECT_EQ(std::isnan(r.x.rer_unfiltered), std::isnan(r.x.rer)) << t;
    EXPECT_TRUE(t > 400.0 || !std::isnan(r.x.rer)) << t;
    EXPECT_NEAR(r.y.rer, std::erf(0.5 / (std::numbers::sqrt2 * s)), 1e-7);
  }
  EXPECT_LE(none, 4);
}

// Light that aerosol scatters takes the part 1 - a of the contrast at every frequency but 0 itself: the rise of an edge
// is a of what it was, the line keeps its width, and MTF50 is where the rest of the MTF has fallen to 1/(2 a); a below
// 1/2 is no blur and has none. The error that is stated is that of the tolerance, as without it.
TEST(Resolution, ContrastLostAtAllFrequenciesIsNoBlur) {
  constexpr double s = 0.4;
  for (const double depth : {0.1, 0.6, 0.7, 3.0}) {
    System<double> system;
    system.frame = {100.0, 10.0, 10.0, 0.0, 0, 0};
    system.add(Stage::presample, gaussian(10.0 * s));
    auto aerosol = Component<double>::make("aerosol");
    set(aerosol, "scattering", depth);
    set(aerosol, "path_length", 1.0);
    system.add(Stage::presample, aerosol);
    ResolutionNeeds needs;
    needs.axis.edge = needs.axis.fwhm = needs.axis.mtf50 = true;
    needs.tolerance = 1e-7;
    const Resolution<double> r = ResolutionMeter<double>(needs).measure(system);
    const double a = std::exp(-depth);
    EXPECT_LE(r.error, 1e-7) << depth;
    EXPECT_NEAR(r.x.rer, a * std::erf(0.5 / (std::numbers::sqrt2 * s)), 1e-7) << depth;
    EXPECT_NEAR(r.x.fwhm_px, 2.0 * s * std::sqrt(2.0 * std::numbers::ln2), 1e-6) << depth;
    EXPECT_EQ(r.veiled, a < 0.5);
    EXPECT_EQ(std::isnan(r.x.mtf50_cy_px), r.veiled);
    if (!r.veiled) {
      EXPECT_NEAR(r.x.mtf50_cy_px, std::sqrt(std::log(2.0 * a) / 2.0) / (kPi * s), 1e-6) << depth;
    }
  }
}

// Nothing ends an RC low-pass alone: esf = 1 - exp(-x/t), at one half at t ln 2.
TEST(Resolution, AnOtfThatNothingEndsHasAnEdge) {
  for (const double t : {0.398, 2.0, 30.0}) {
    System<double> system;
    system.frame = {100.0, 10.0, 10.0, 0.0, 0, 0};
    auto rc = Component<double>::make("rc_lowpass");
    set(rc, "cutoff", 100.0 / (2.0 * kPi * t), "cy/mm");
    system.add(Stage::presample, rc);
    ResolutionNeeds needs;
    needs.axis.edge = true;
    needs.tolerance = 1e-4;
    const Resolution<double> r = ResolutionMeter<double>(needs).measure(system);
    const auto esf = [&](double x) { return x > 0.0 ? -std::expm1(-x / t) : 0.0; };
    const double middle = t * std::numbers::ln2;
    EXPECT_NEAR(r.x.rer, esf(middle + 0.5) - esf(middle - 0.5), std::max(r.error, 1e-3)) << t;
  }
}

}  // namespace
}  // namespace mtf::test
