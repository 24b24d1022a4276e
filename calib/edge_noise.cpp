// SPDX-License-Identifier: Apache-2.0
#include "calib/edge_noise.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace calib {
namespace {

struct Spread {
  double sum = 0.0, dof = 0.0;
  double variance() const { return dof > 0.0 ? sum / dof : 0.0; }
  double error() const { return std::sqrt(2.0 / std::max(dof, 1.0)); }  // relative, of the variance
};

}  // namespace

NoiseModel estimate_noise(const EdgeSums& sums, const StepProfile& profile, double least, const Rounding& rounding) {
  constexpr double kPlateau = 0.08;
  Spread dark, bright;
  for (int i = 0; i < kBins; ++i) {
    if (sums.count(i) < 2.0) continue;
    const double esf = profile.esf[static_cast<std::size_t>(i)];
    if (esf >= kPlateau && esf <= 1.0 - kPlateau) continue;
    Spread& side = esf < 0.5 ? dark : bright;
    side.sum += sums.pure_error(i);
    side.dof += sums.count(i) - 1.0;
  }
  NoiseModel noise{.least_dark = std::max(least, rounding.dark * rounding.dark / 12.0),
                   .least_bright = std::max(least, rounding.bright * rounding.bright / 12.0)};
  constexpr double kFewest = 20.0;
  const Spread both{dark.sum + bright.sum, dark.dof + bright.dof};
  noise.dark = std::max(noise.least_dark, both.variance());
  noise.bright = std::max(noise.least_bright, both.variance());
  if (std::min(dark.dof, bright.dof) >= kFewest) {
    const double a = std::max(noise.least_dark, dark.variance()), b = std::max(noise.least_bright, bright.variance());
    if (std::abs(std::log(b / a)) > 3.5 * std::hypot(dark.error(), bright.error())) noise.dark = a, noise.bright = b;
  }
  // Across the edge the same pixels may show more: rounding that the plateaus hide.
  Spread seen, expected;
  for (int i = 0; i < kBins; ++i) {
    const double esf = profile.esf[static_cast<std::size_t>(i)];
    if (sums.count(i) < 2.0 || esf < kPlateau || esf > 1.0 - kPlateau) continue;
    seen.sum += sums.pure_error(i);
    expected.sum += (sums.count(i) - 1.0) * noise.at(esf);
    seen.dof += sums.count(i) - 1.0;
  }
  if (seen.dof >= kFewest && seen.sum > expected.sum * (1.0 + 5.0 * seen.error())) {
    const double ratio = seen.sum / expected.sum;
    noise.dark *= ratio;
    noise.bright *= ratio;
  }
  return noise;
}

std::vector<double> pixel_weights(const EdgeSums& sums, const EdgeModel& model, const StepProfile& profile,
                                  const NoiseModel& noise, const Rounding& rounding) {
  constexpr double kLong = 0.25;  // of the blur's width
  std::vector<double> weight(kBins);
  for (std::size_t i = 0; i < kBins; ++i) weight[i] = 1.0 / noise.at(profile.esf[i]);
  const double long_px = kLong / std::max(1e-3, std::abs(profile.lsf[kSideBins]));
  const auto share = [&](bool bright, double step, double variance) {
    const double dither = std::max(0.0, variance / (step * step) - 1.0 / 12.0);
    const double shared = step * step / 12.0 * std::exp(-4.0 * std::numbers::pi * std::numbers::pi * dither);
    const auto bin = [&](int k) { return bright ? kBins - 1 - k : k; };  // from the far end inwards
    const auto step_of = [&](int k) {
      const double esf = profile.esf[static_cast<std::size_t>(bin(k))];
      return std::round(2.0 * model.contrast() * (bright ? 1.0 - esf : esf) / step);
    };
    for (int first = 0, last = 0; first < kSideBins; first = last) {
      double n = 0.0, length_px = 0.0;
      for (; last < kSideBins && step_of(last) == step_of(first); ++last) {
        n += sums.count(bin(last));
        length_px += DistanceBins::get().width(bin(last));
      }
      if (length_px < long_px) break;
      for (int k = first; k < last; ++k) {
        double& one = weight[static_cast<std::size_t>(bin(k))];
        one = 1.0 / (1.0 / one + n * shared);
      }
    }
  };
  if (rounding.dark > 0.0) share(false, rounding.dark, noise.dark);
  if (rounding.bright > 0.0) share(true, rounding.bright, noise.bright);
  return weight;
}

}  // namespace calib
