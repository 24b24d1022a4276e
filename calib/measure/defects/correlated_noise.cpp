// SPDX-License-Identifier: Apache-2.0
#include "calib/measure/defects/correlated_noise.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

#include "mtf/engines/clones.h"

namespace calib {
namespace {

constexpr int kMostRings = 5, kMargin_px = 10;

// Residuals of the flat sides in units of their standard deviation on the grid of the pixels, 0 where there is none,
// with a margin wide enough that no lag joins the end of a row to the start of another.
struct Grid {
  std::size_t stride = 0, size = 0;
  std::vector<float> residual, flat, present;
  double count = 0.0, mean_square = 0.0;
};

Grid grid_of(const EdgePixels& pixels, const EdgeModel& model, const FitState& state, double from_px) {
  const PixelResiduals all = residuals_of(pixels, model, state.profile);
  const auto [left, right] = std::minmax_element(pixels.x(), pixels.x() + pixels.size());
  const auto [top, bottom] = std::minmax_element(pixels.y(), pixels.y() + pixels.size());
  Grid grid;
  grid.stride = static_cast<std::size_t>(std::lround(*right - *left)) + 1 + kMargin_px;
  grid.size = grid.stride * (static_cast<std::size_t>(std::lround(*bottom - *top)) + 1);
  grid.residual.assign(grid.size + (kMargin_px + 1) * grid.stride, 0.0F);
  grid.flat = grid.present = grid.residual;
  BinRow per_sd;
  const BinRow variance = variances(state.noise, state.profile);
  for (int b = 0; b < kBins; ++b) {
    const auto at = static_cast<std::size_t>(b);
    per_sd[at] = std::abs(DistanceBins::get().centre(b)) < from_px ? 0.0 : 1.0 / std::sqrt(variance[at]);
  }
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    const auto column = static_cast<std::size_t>(pixels.x()[i] - *left + 0.5),
               row = static_cast<std::size_t>(pixels.y()[i] - *top + 0.5);
    const std::size_t at = row * grid.stride + column;
    grid.present[at] = 1.0F;
    const auto bin = static_cast<std::size_t>(all.bin[i]);
    if (bin >= kBins || per_sd[bin] == 0.0) continue;
    const double value = all.residual[i] * per_sd[bin];
    grid.residual[at] = static_cast<float>(value);
    grid.flat[at] = 1.0F;
    grid.count += 1.0;
    grid.mean_square += value * value;
  }
  grid.mean_square /= std::max(1.0, grid.count);
  return grid;
}

MTFKIT_CLONES float sum_of_products(const float* __restrict a, const float* __restrict b, std::size_t n) {
  constexpr std::size_t kLanes = 32;
  std::array<float, kLanes> sum{};
  std::size_t i = 0;
  for (; i + kLanes <= n; i += kLanes)
    for (std::size_t k = 0; k < kLanes; ++k) sum[k] += a[i + k] * b[i + k];
  for (; i < n; ++i) sum[0] += a[i] * b[i];
  return std::accumulate(sum.begin(), sum.end(), 0.0F);
}

// The lags of one half plane whose larger coordinate is `ring`, and what they add up to.
struct Ring {
  std::vector<NoiseLag> lags;
  double chi2 = 0.0;     // of the correlations, were the pixels independent
  double squares = 0.0;  // of the correlations
};

// Sum over the grid of the products of each value with that of the neighbour.
double sum_of_products(const Grid& grid, const std::vector<float>& values, int x, int y) {
  const auto before = static_cast<std::size_t>(std::max(0, -x));
  const auto ahead = static_cast<std::size_t>(y) * grid.stride + static_cast<std::size_t>(std::max(0, x));
  return static_cast<double>(sum_of_products(values.data() + before, values.data() + ahead, grid.size - before));
}

Ring ring_of(const Grid& grid, int ring) {
  Ring found;
  for (int y = 0; y <= ring; ++y)
    for (int x = y == 0 ? ring : -ring; x <= ring; x += y == ring ? 1 : 2 * ring) {
      const double pairs = sum_of_products(grid, grid.flat, x, y);
      if (pairs < 1.0) continue;
      const double correlation = sum_of_products(grid, grid.residual, x, y) / (pairs * grid.mean_square);
      found.lags.push_back({x, y, correlation});
      found.chi2 += correlation * correlation * pairs;
      found.squares += correlation * correlation;
    }
  return found;
}

// The mean correlation of pixels far from each other along the edge. That of noise has ended there; structure, and what
// the model misses at a distance from the edge, is the same all along it.
double far_correlation(const Grid& grid, Point normal) {
  constexpr std::array<double, 4> kFar_px{7.0, 8.0, 9.0, 10.0};
  double products = 0.0, pairs = 0.0;
  for (const double away_px : kFar_px) {
    const double sign = normal.x < 0.0 ? -1.0 : 1.0;
    const int x = static_cast<int>(std::lround(-sign * normal.y * away_px)),
              y = static_cast<int>(std::lround(sign * normal.x * away_px));
    products += sum_of_products(grid, grid.residual, x, y);
    pairs += sum_of_products(grid, grid.flat, x, y);
  }
  return products / std::max(1.0, pairs) / grid.mean_square;
}

}  // namespace

NoiseCorrelation correlation_of(const EdgePixels& pixels, const EdgeModel& model, const FitState& state,
                                const Rounding& rounding) {
  constexpr double kFewest = 100.0;    // pixels
  constexpr double kSureOfAny = 30.0;  // chi2 of the four nearest lags: once in 2 x 10^5 edges
  constexpr double kLeastRms = 0.02;   // of the nearest lags: less changes no interval by a tenth
  constexpr double kStructure = 0.3;   // of that rms, in pixels that are far from each other
  constexpr double kLeastSteps2 = 0.25;
  constexpr double kSureOfMore = 1.0;  // standard deviations of the chi2 of a ring
  constexpr double kTerms = 6.0;       // fitted: plateaus and gradients, and tails that take the part of gradients
  constexpr double kMargin = 1.1, kErrorMargin = 6.0;
  const double from_px = 2.0 / std::max(1e-3, state.profile.lsf()[kSideBins]);
  const Grid grid = grid_of(pixels, model, state, from_px);
  NoiseCorrelation correlation;
  const bool rounded = state.noise.dark < kLeastSteps2 * rounding.dark * rounding.dark ||
                       state.noise.bright < kLeastSteps2 * rounding.bright * rounding.bright;
  if (grid.count < kFewest || !(grid.mean_square > 0.0) || rounded) return correlation;
  double squares = 1.0, sum = 1.0, lags = 1.0;
  for (int ring = 1; ring <= kMostRings; ++ring) {
    const Ring next = ring_of(grid, ring);
    const auto count = static_cast<double>(next.lags.size());
    // The estimates of correlated noise scatter by more (M. S. Bartlett, J. R. Stat. Soc. Suppl. 8, 27 (1946)).
    const double sure = ring == 1 ? kSureOfAny : squares * (count + kSureOfMore * std::sqrt(2.0 * count));
    if (!(next.chi2 > sure)) break;
    const double rms = std::sqrt(next.squares / std::max(1.0, count));
    if (ring == 1 && (rms < kLeastRms || far_correlation(grid, model.curve.normal()) > kStructure * rms)) break;
    squares += 2.0 * next.squares;
    lags += 2.0 * count;
    for (const NoiseLag& lag : next.lags) sum += 2.0 * lag.correlation;
    correlation.lags.insert(correlation.lags.end(), next.lags.begin(), next.lags.end());
  }
  const double taken = kTerms / static_cast<double>(pixels.size());
  const double lost = taken * std::max(0.0, sum) / std::max(0.5, 1.0 - taken * lags);
  // The sum of the correlations, which scales the variances at low frequencies, has the relative variance 2 lags /
  // count: intervals of an estimated variance have to be wider, as those of Student's t, and where the fit goes by
  // noise that is too small it ends at bounds of the blur. With this margin the 95 % intervals hold (bench_coverage).
  correlation.margin = kMargin + kErrorMargin * 2.0 * lags / grid.count;
  for (NoiseLag& lag : correlation.lags) {
    lag.correlation = (lag.correlation + lost) / (1.0 + lost);
    lag.share = sum_of_products(grid, grid.present, lag.x, lag.y) / static_cast<double>(pixels.size());
  }
  return correlation;
}

}  // namespace calib
