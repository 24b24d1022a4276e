// SPDX-License-Identifier: Apache-2.0
#include "calib/measure/defects/correlated_noise.h"

#include <algorithm>
#include <cmath>

namespace calib {
namespace {

constexpr std::size_t kEnough = 1U << 18;  // pixels: their rows bound the memory of the grid

// Residuals of the flat sides in units of their standard deviation.
PixelGrid grid_of(const EdgePixels& pixels, const EdgeModel& model, const FitState& state) {
  const std::size_t size = std::min(pixels.size(), kEnough);
  const PixelResiduals all = residuals_of(pixels, model, state.profile);
  const auto [left, right] = std::minmax_element(pixels.x(), pixels.x() + size);
  const auto [top, bottom] = std::minmax_element(pixels.y(), pixels.y() + size);
  PixelGrid grid(static_cast<std::size_t>(std::lround(*right - *left)) + 1,
                 static_cast<std::size_t>(std::lround(*bottom - *top)) + 1);
  const double from_px = 2.0 / std::max(1e-3, state.profile.lsf()[kSideBins]);
  BinRow per_sd = variances(state.noise, state.profile);
  for (int b = 0; b < kBins; ++b) {
    double& one = per_sd[static_cast<std::size_t>(b)];
    one = std::abs(DistanceBins::get().centre(b)) < from_px ? 0.0 : 1.0 / std::sqrt(one);
  }
  for (std::size_t i = 0; i < size; ++i) {
    const auto column = static_cast<std::size_t>(pixels.x()[i] - *left + 0.5),
               row = static_cast<std::size_t>(pixels.y()[i] - *top + 0.5);
    const auto bin = static_cast<std::size_t>(all.bin[i]);
    if (bin < kBins && per_sd[bin] > 0.0)
      grid.set(column, row, all.residual[i] * per_sd[bin]);
    else
      grid.set(column, row);
  }
  return grid;
}

// The lags of whole columns and rows: at most kMost of each, evenly spaced, for all.
void add_lines(const PixelGrid& grid, int rings, NoiseCorrelation& noise) {
  constexpr int kMost = 64;
  for (const bool columns : {true, false}) {
    const double shared = columns ? noise.columns : noise.rows;
    if (shared == 0.0) continue;
    const auto length = static_cast<int>(columns ? grid.rows() : grid.columns()), step = 1 + (length - 1) / kMost;
    for (int k = rings + (step + 1) / 2; k < length; k += step)
      noise.lags.push_back({.x = columns ? 0 : k,
                            .y = columns ? k : 0,
                            .correlation = shared * step,
                            .share = 1.0 - static_cast<double>(k) / length});
  }
}

}  // namespace

NoiseCorrelation noise_correlation(const EdgePixels& pixels, const EdgeModel& model, const FitState& state,
                                   const Rounding& rounding) {
  const bool rounded = state.noise.dark < kRoundsAlike_steps2 * rounding.dark * rounding.dark ||
                       state.noise.bright < kRoundsAlike_steps2 * rounding.bright * rounding.bright;
  if (pixels.size() == 0 || rounded) return {};
  const PixelGrid grid = grid_of(pixels, model, state);
  const Point normal = model.curve.normal();
  const PixelCorrelation near = correlation_of(grid, normal);
  NoiseCorrelation noise = noise_correlation(near, grid.count(), static_cast<double>(pixels.size()));
  for (PixelLag& lag : noise.lags)
    lag.share = grid.pixel_pairs(lag.x, lag.y) / static_cast<double>(std::min(pixels.size(), kEnough));
  noise.columns = shared_in_lines(grid, normal, true, near.rings);
  noise.rows = shared_in_lines(grid, normal, false, near.rings);
  add_lines(grid, near.rings, noise);
  return noise;
}

}  // namespace calib
