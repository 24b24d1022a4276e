// SPDX-License-Identifier: Apache-2.0
#include "mtf/tiles/tile_layout.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace mtf {
namespace {

constexpr std::int64_t kLargestDenominator = 64;
constexpr double kRoundingOfRatio = 4e-16;  // of a quotient of two decimals
constexpr double kRough = 1.6;              // a transform of a length with large factors, against a smooth one

std::int64_t round_up(std::int64_t n, std::int64_t to) { return (n + to - 1) / to * to; }

double cost_per_pixel(const TileAxis& axis) {
  const auto length = static_cast<double>(axis.canvas_samples());
  return length * (std::log2(length) + 8.0) * (is_smooth(axis.canvas_samples()) ? 1.0 : kRough) /
         static_cast<double>(std::min(axis.tile, axis.skipped + axis.outputs));
}

}  // namespace

std::optional<PitchRatio> pitch_ratio(double pitch_um, double step_um) {
  const double ratio = pitch_um / step_um;
  for (std::int64_t q = 1; q <= kLargestDenominator; ++q) {
    const double p = std::round(ratio * static_cast<double>(q));
    if (p >= 1.0 && p < 1e9 && std::abs(ratio * static_cast<double>(q) - p) <= kRoundingOfRatio * p)
      return PitchRatio{static_cast<std::int64_t>(p), q};
  }
  return std::nullopt;
}

std::optional<TileAxis> tile_axis(const TileRequest& request) {
  const auto [p, q] = request.ratio;
  TileAxis axis;
  axis.ratio = request.ratio;
  axis.outputs = request.outputs;
  axis.first = request.region_first / q * q;
  axis.skipped = request.region_first - axis.first;
  axis.post = request.post_pixels;
  axis.margin = round_up(axis.post, q) + round_up(request.halo_samples, p) / p * q;
  const std::int64_t whole = round_up(axis.skipped + axis.outputs, q);
  if (request.side > 0) {
    axis.tile = std::min(round_up(request.side, q), whole);
    return axis;
  }
  std::optional<TileAxis> best;
  double least = std::numeric_limits<double>::infinity();
  for (axis.tile = q; axis.canvas_samples() <= request.most_samples; axis.tile += q) {
    const double cost = cost_per_pixel(axis);
    if (cost < least) least = cost, best = axis;
    if (axis.tile >= 2 * whole) break;  // up to here a longer tile may be the smooth one
  }
  return best;
}

}  // namespace mtf
