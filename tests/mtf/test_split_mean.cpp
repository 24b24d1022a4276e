// SPDX-License-Identifier: Apache-2.0
#include "mtf/otf/split_mean.h"

#include <gtest/gtest.h>

#include <cmath>

#include "mtf/components/field.h"

namespace mtf::test {
namespace {

/// What a rate of straight lines between samples gives, up to a factor.
Band sampled_band(std::vector<double> wavelength_um, std::vector<double> rate) {
  Band band{wavelength_um.front(), wavelength_um.back(), nullptr};
  const auto at = [wavelength_um, rate](double w) {
    std::size_t i = 1;
    while (i + 1 < wavelength_um.size() && wavelength_um[i] < w) ++i;
    const double share = (w - wavelength_um[i - 1]) / (wavelength_um[i] - wavelength_um[i - 1]);
    return rate[i - 1] * (1.0 - share) + rate[i] * share;
  };
  band.rate = std::make_shared<const ElectronRate>(nullptr, at, std::move(wavelength_um));
  return band;
}

/// Mean of the power 3/2 of the distance beyond a kink.
SplitMean<double, 1> beyond_kink(BandWeights& weights, double kink_um, double tolerance, bool told) {
  const auto at = [kink_um](double w) {
    return std::array{Complex<double>{std::pow(std::max(0.0, w - kink_um), 1.5), 0.0}};
  };
  const std::vector<double> kinks = told ? std::vector{kink_um} : std::vector<double>{};
  return split_mean<double, 1>(weights, kinks, kInfinity, tolerance, at);
}

// The mean over [8, 12] is (12 - k)^2.5 / 2.5 / 4.
TEST(SplitMean, AKinkThatIsKnownCostsNothing) {
  BandWeights weights;
  weights.set({8.0, 12.0, nullptr});
  for (const double kink : {8.0, 8.0001, 9.3, 11.999, 13.0}) {
    const double exact = std::pow(std::max(0.0, 12.0 - kink), 2.5) / 10.0;
    const SplitMean<double, 1> told = beyond_kink(weights, kink, 1e-12, true);
    EXPECT_NEAR(told.value[0].re, exact, 1e-13) << kink;
    EXPECT_LE(told.wavelengths, 70) << kink;
    // One that is not known is found: the tolerance holds at more wavelengths.
    const SplitMean<double, 1> found = beyond_kink(weights, kink, 1e-9, false);
    EXPECT_NEAR(found.value[0].re, exact, 1e-9) << kink;
    EXPECT_LE(found.error, 2e-9) << kink;
  }
}

// The integral of (w - k)^1.5 (a + b w) by hand, on each line of the rate.
TEST(SplitMean, TheSamplesOfTheRateAreInTheWeights) {
  const std::vector<double> wavelength_um{8.0, 8.5, 8.6, 10.0, 11.5, 12.0}, rate{0.0, 0.9, 0.2, 0.8, 0.7, 0.1};
  BandWeights weights;
  weights.set(sampled_band(wavelength_um, rate));
  for (const double kink : {7.0, 8.55, 9.3, 11.7}) {
    double sum = 0.0, total = 0.0;
    for (std::size_t i = 1; i < rate.size(); ++i) {
      const double lo = wavelength_um[i - 1], hi = wavelength_um[i], slope = (rate[i] - rate[i - 1]) / (hi - lo);
      total += 0.5 * (rate[i] + rate[i - 1]) * (hi - lo);
      const double at_kink = rate[i - 1] + slope * (kink - lo);
      const auto integral = [&](double w) {
        const double d = std::max(0.0, w - kink);
        return at_kink * std::pow(d, 2.5) / 2.5 + slope * std::pow(d, 3.5) / 3.5;
      };
      sum += integral(hi) - integral(lo);
    }
    const SplitMean<double, 1> mean = beyond_kink(weights, kink, 1e-12, true);
    EXPECT_NEAR(mean.value[0].re, sum / total, 1e-12 * std::max(1.0, sum / total)) << kink;
    EXPECT_LE(mean.wavelengths, 100) << kink;  // not some for each sample
  }
}

// Lines as narrow as those of the air's spectra, some of them falling to nothing: the place on each is rounded by 1e-13
// of its length, and what that does to the rate must not be halved without end.
TEST(SplitMean, NarrowSteepSamplesEnd) {
  std::vector<double> wavelength_um, rate;
  for (int i = 0; i <= 400; ++i) {
    wavelength_um.push_back(1e4 / (3000.0 - 2.5 * i));
    rate.push_back(i % 3 == 0 ? 1.0 : i % 3 == 1 ? 1e-3 : 0.0);
  }
  double total = 0.0, sum = 0.0;
  for (std::size_t i = 1; i < rate.size(); ++i) {
    const double lo = wavelength_um[i - 1], h = wavelength_um[i] - lo, slope = (rate[i] - rate[i - 1]) / h;
    total += 0.5 * (rate[i] + rate[i - 1]) * h;
    sum += rate[i - 1] * (lo * h + 0.5 * h * h) + slope * (0.5 * lo * h * h + h * h * h / 3.0);
  }
  BandWeights weights;
  weights.set(sampled_band(wavelength_um, rate));
  const auto mean = split_mean<double, 1>(weights, {}, kInfinity, 1e-12, [](double w) {
    return std::array{Complex<double>{w, 0.0}};
  });
  EXPECT_NEAR(mean.value[0].re, sum / total, 1e-11 * sum / total);
}

}  // namespace
}  // namespace mtf::test
