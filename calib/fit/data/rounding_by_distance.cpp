// SPDX-License-Identifier: Apache-2.0
#include "calib/fit/data/rounding_by_distance.h"

#include <algorithm>
#include <array>
#include <numeric>

namespace calib {
namespace {

constexpr double kNear_px = 0.125;

// Of the deviations of pixels from their mean.
struct Scatter {
  double squares = 0.0, dof = 0.0;
  void add(const Scatter& other) { squares += other.squares, dof += other.dof; }
};

}  // namespace

RoundingByDistance rounding_by_distance(std::span<const Residual> residuals, std::span<const double> esf,
                                        double quantum) {
  constexpr double kPlateau = 0.08, kFewest = 4.0;
  std::vector<std::size_t> order(residuals.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  const auto distance = [&](std::size_t i) { return residuals[order[i]].distance_px; };
  std::sort(order.begin(), order.end(),
            [&](std::size_t a, std::size_t b) { return residuals[a].distance_px < residuals[b].distance_px; });

  RoundingByDistance found{.alike = std::vector<double>(residuals.size())};
  for (std::size_t i = 0, first = 0, end = 0; i < order.size(); ++i) {
    while (end < order.size() && distance(end) <= distance(i) + kNear_px) ++end;
    while (distance(first) < distance(i) - kNear_px) ++first;
    found.alike[order[i]] = static_cast<double>(end - first);
  }

  double sum = 0.0, places = 0.0;
  const auto take = [&](const Scatter& place) {
    if (place.dof < kFewest) return;
    sum += place.squares / place.dof;
    places += 1.0;
  };
  std::array<Scatter, 2> plateaus{};
  for (std::size_t first = 0, end = 0; first < order.size(); first = end) {
    double n = 0.0, mean = 0.0;
    Scatter here{.squares = 0.0, .dof = -1.0};
    for (; end < order.size() && distance(end) <= distance(first) + 2.0 * kNear_px; ++end) {
      const Residual& r = residuals[order[end]];
      const double steps = r.value * r.sd / quantum, change = steps - mean;
      mean += change / (n += 1.0);
      here.squares += change * (steps - mean);
      here.dof += 1.0;
    }
    const double e = esf[order[first]];
    if (e > kPlateau && e < 1.0 - kPlateau)
      take(here);
    else
      plateaus[e < 0.5 ? 0 : 1].add(here);
  }
  for (const Scatter& plateau : plateaus) take(plateau);
  if (places > 0.0) found.noise_steps2 = std::max(0.0, sum / places - 1.0 / 12.0);
  return found;
}

}  // namespace calib
