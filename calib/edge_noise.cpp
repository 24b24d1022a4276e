// SPDX-License-Identifier: Apache-2.0
#include "calib/edge_noise.h"

#include <algorithm>
#include <cmath>

namespace calib {
namespace {

struct Spread {
  double sum = 0.0, dof = 0.0;
  double variance() const { return dof > 0.0 ? sum / dof : 0.0; }
  double error() const { return std::sqrt(2.0 / std::max(dof, 1.0)); }  // relative, of the variance
};

}  // namespace

NoiseModel estimate_noise(const EdgeSums& sums, const StepProfile& profile, double least) {
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
  NoiseModel noise{.least = least};
  constexpr double kFewest = 20.0;
  const Spread both{dark.sum + bright.sum, dark.dof + bright.dof};
  noise.dark = noise.bright = std::max(least, both.variance());
  if (std::min(dark.dof, bright.dof) >= kFewest) {
    const double a = std::max(least, dark.variance()), b = std::max(least, bright.variance());
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

}  // namespace calib
