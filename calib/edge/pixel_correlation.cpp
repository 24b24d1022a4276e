// SPDX-License-Identifier: Apache-2.0
#include "calib/edge/pixel_correlation.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "mtf/math/clones.h"

namespace calib {
namespace {

MTFKIT_CLONES float sum_of_products(const float* a, const float* b, std::size_t n) {
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
  std::vector<PixelLag> lags;
  double chi2 = 0.0;     // of the correlations, were the pixels independent
  double squares = 0.0;  // of the correlations
  double rms() const { return std::sqrt(squares / std::max(1.0, static_cast<double>(lags.size()))); }
};

Ring ring_of(const PixelGrid& grid, int ring) {
  Ring found;
  for (int y = 0; y <= ring; ++y)
    for (int x = y == 0 ? ring : -ring; x <= ring; x += y == ring ? 1 : 2 * ring) {
      const double pairs = grid.value_pairs(x, y);
      if (pairs < 1.0) continue;
      const double correlation = grid.products(x, y) / (pairs * grid.mean_square());
      found.lags.push_back({x, y, correlation});
      found.chi2 += correlation * correlation * pairs;
      found.squares += correlation * correlation;
    }
  return found;
}

double far_correlation(const PixelGrid& grid, Point normal) {
  constexpr std::array<double, 4> kFar_px{7.0, 8.0, 9.0, PixelGrid::kFarthest_px};
  const double sign = normal.x < 0.0 ? -1.0 : 1.0;
  double products = 0.0, pairs = 0.0;
  for (const double away_px : kFar_px) {
    const int x = static_cast<int>(std::lround(-sign * normal.y * away_px)),
              y = static_cast<int>(std::lround(sign * normal.x * away_px));
    products += grid.products(x, y);
    pairs += grid.value_pairs(x, y);
  }
  return products / std::max(1.0, pairs) / grid.mean_square();
}

}  // namespace

PixelGrid::PixelGrid(std::size_t columns, std::size_t rows)
    : stride_(columns + kFarthest_px), size_(stride_ * rows), value_(size_ + (kFarthest_px + 1) * stride_, 0.0F) {
  known_ = present_ = value_;
}

void PixelGrid::set(std::size_t column, std::size_t row, double value) {
  set(column, row);
  value_[row * stride_ + column] = static_cast<float>(value);
  known_[row * stride_ + column] = 1.0F;
  count_ += 1.0;
  squares_ += value * value;
}

double PixelGrid::sum_over_lag(const std::vector<float>& values, int x, int y) const {
  const auto before = static_cast<std::size_t>(std::max(0, -x));
  const auto ahead = static_cast<std::size_t>(y) * stride_ + static_cast<std::size_t>(std::max(0, x));
  return static_cast<double>(sum_of_products(values.data() + before, values.data() + ahead, size_ - before));
}

PixelCorrelation correlation_of(const PixelGrid& grid, Point normal) {
  constexpr int kMostRings = 5;
  constexpr double kFewest = 100.0;    // pixels
  constexpr double kSureOfAny = 30.0;  // chi2 of the four nearest lags: once in 2 x 10^5 edges
  constexpr double kLeastRms = 0.02;   // of the nearest lags: less changes no interval by a tenth
  constexpr double kStructure = 0.3;   // of that rms, in pixels that are far from each other
  constexpr double kSureOfMore = 1.0;  // standard deviations of the chi2 of a ring
  PixelCorrelation found;
  if (grid.count() < kFewest || !(grid.mean_square() > 0.0)) return found;
  double squares = 1.0;
  for (int ring = 1; ring <= kMostRings; ++ring) {
    const Ring next = ring_of(grid, ring);
    const auto count = static_cast<double>(next.lags.size());
    // The estimates of correlated noise scatter by more (M. S. Bartlett, J. R. Stat. Soc. Suppl. 8, 27 (1946)).
    const double sure = ring == 1 ? kSureOfAny : squares * (count + kSureOfMore * std::sqrt(2.0 * count));
    if (!(next.chi2 > sure)) break;
    if (ring == 1 && (next.rms() < kLeastRms || far_correlation(grid, normal) > kStructure * next.rms())) break;
    found.rings = ring;
    squares += 2.0 * next.squares;
    for (const PixelLag& lag : next.lags) found.sum += 2.0 * lag.correlation;
    found.lags.insert(found.lags.end(), next.lags.begin(), next.lags.end());
  }
  return found;
}

PixelGrid::Pairs PixelGrid::pairs_in_lines(bool columns) const {
  Pairs pairs;
  const std::size_t lines = columns ? this->columns() : rows(), length = columns ? rows() : this->columns();
  for (std::size_t line = 0; line < lines; ++line) {
    double sum = 0.0, squares = 0.0, count = 0.0;
    for (std::size_t k = 0; k < length; ++k) {
      const std::size_t at = columns ? k * stride_ + line : line * stride_ + k;
      const auto value = static_cast<double>(value_[at]);
      sum += value;
      squares += value * value;
      count += static_cast<double>(known_[at]);
    }
    pairs.products += 0.5 * (sum * sum - squares);
    pairs.count += 0.5 * count * (count - 1.0);
  }
  return pairs;
}

double shared_in_lines(const PixelGrid& grid, Point normal, bool columns, int rings) {
  constexpr double kSure = 5.0;  // standard deviations
  PixelGrid::Pairs pairs = grid.pairs_in_lines(columns);
  for (int k = 1; k <= rings; ++k) {
    pairs.products -= grid.products(columns ? 0 : k, columns ? k : 0);
    pairs.count -= grid.value_pairs(columns ? 0 : k, columns ? k : 0);
  }
  if (pairs.count < 1.0 || !(grid.mean_square() > 0.0)) return 0.0;
  const double structure = std::max(0.0, far_correlation(grid, normal));
  const double shared = pairs.products / (pairs.count * grid.mean_square()) - structure;
  return shared * std::sqrt(pairs.count) > kSure ? shared : 0.0;
}

double NoiseCorrelation::sum() const {
  double all = 1.0;
  for (const PixelLag& lag : lags) all += 2.0 * margin * lag.correlation;
  return all;
}

NoiseCorrelation noise_correlation(const PixelCorrelation& residuals, double values, double pixels) {
  constexpr double kTerms = 6.0;  // fitted: plateaus and gradients, and tails that take the part of gradients
  constexpr double kMargin = 1.1, kErrorMargin = 6.0;
  const double lags = 1.0 + 2.0 * static_cast<double>(residuals.lags.size());
  const double taken = kTerms / pixels;
  const double lost = taken * std::max(0.0, residuals.sum) / std::max(0.5, 1.0 - taken * lags);
  // The sum of the correlations, which scales the variances at low frequencies, has the relative variance 2 lags /
  // count. Intervals from an estimated variance have to be wider, as those of Student's t, and the tests for terms and
  // diffraction err where it is estimated too small. With this margin the 95 % intervals hold (bench_coverage).
  NoiseCorrelation noise{.lags = residuals.lags, .margin = kMargin + kErrorMargin * 2.0 * lags / std::max(1.0, values)};
  for (PixelLag& lag : noise.lags) lag.correlation = (lag.correlation + lost) / (1.0 + lost);
  return noise;
}

}  // namespace calib
