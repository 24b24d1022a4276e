// SPDX-License-Identifier: Apache-2.0
#include "calib/find/find_segments.h"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <span>

#include "calib/edge/median.h"
#include "mtf/work/stop.h"

namespace calib::find {
namespace {

constexpr std::int64_t kMostCells = std::int64_t{1} << 24;
constexpr double kSparse = 0.6;                 // share of numbers below which pixels are paired
constexpr std::int64_t kMostSamples = 1 << 20;  // for the noise
constexpr float kNone = std::numeric_limits<float>::quiet_NaN();

/// Smoothing along an axis, and what it leaves of white noise in a gradient: central differences along x of binomials
/// along x and y.
constexpr std::array<float, 5> kBinomial{1.0F / 16, 4.0F / 16, 6.0F / 16, 4.0F / 16, 1.0F / 16};
constexpr double kGradientNoise = 0.1498;
/// Standard deviations of a gradient's component that noise does not exceed in millions of cells.
constexpr double kNoiseMargin = 6.0;
double valid_share(mtf::ImageView<const float> image) {
  std::int64_t valid = 0;
  for (std::int64_t y = 0; y < image.height; ++y) {
    mtf::require_going_on();
    for (std::int64_t x = 0; x < image.width; ++x) valid += std::isfinite(image.at(x, y)) ? 1 : 0;
  }
  return static_cast<double>(valid) / static_cast<double>(image.width * image.height);
}

/// The least and the largest value that at least three cells of some 3 x 3 neighbourhood have in common: one wild
/// pixel, or two that touch, are no part of the range. Only a cell beyond the range so far can extend it.
struct Range {
  float low = std::numeric_limits<float>::max(), high = std::numeric_limits<float>::lowest();
  double size() const { return static_cast<double>(high) - static_cast<double>(low); }
};
Range shared_range(const Cells& cells) {
  Range range;
  const auto third = [&](std::int64_t x, std::int64_t y, float sign) {
    std::array<float, 9> values;
    std::size_t count = 0;
    for (std::int64_t j = std::max<std::int64_t>(0, y - 1); j <= std::min(cells.height - 1, y + 1); ++j)
      for (std::int64_t i = std::max<std::int64_t>(0, x - 1); i <= std::min(cells.width - 1, x + 1); ++i)
        if (const float value = cells.at(i, j); !std::isnan(value)) values[count++] = sign * value;
    if (count < 3) return sign * std::numeric_limits<float>::lowest();
    std::nth_element(values.begin(), values.begin() + 2, values.begin() + count, std::greater<>());
    return sign * values[2];
  };
  for (std::int64_t y = 0; y < cells.height; ++y) {
    mtf::require_going_on();
    for (std::int64_t x = 0; x < cells.width; ++x) {
      const float value = cells.at(x, y);
      if (value > range.high) range.high = std::max(range.high, third(x, y, 1.0F));
      if (value < range.low) range.low = std::min(range.low, third(x, y, -1.0F));
    }
  }
  return range;
}

/// The median of |second differences along both axes|, which planes and straight edges along an axis do not show.
/// J. Immerkaer, Fast noise variance estimation, CVIU 64, 300 (1996), with a median in place of the mean.
double noise_of(const Cells& cells) {
  const std::int64_t inner = std::max<std::int64_t>(0, cells.width - 2) * std::max<std::int64_t>(0, cells.height - 2);
  const std::int64_t stride = 1 + inner / kMostSamples;
  std::vector<float> sample;
  for (std::int64_t i = 0; i < inner; i += stride) {
    const std::int64_t x = 1 + i % (cells.width - 2), y = 1 + i / (cells.width - 2);
    const auto row = [&](std::int64_t at) {
      return cells.at(x - 1, at) - 2.0F * cells.at(x, at) + cells.at(x + 1, at);
    };
    const float second = row(y - 1) - 2.0F * row(y) + row(y + 1);
    if (std::isfinite(second)) sample.push_back(std::abs(second));
  }
  if (sample.empty()) return 0.0;
  return static_cast<double>(median(sample)) / (0.6745 * 6.0);
}

/// Single cells far above or below all of their neighbours but one, as hot and dead pixels are (two of them may touch),
/// become cells without a value: each would count as structure, and end the region around an edge. No optics makes such
/// a spike that would be larger than the noise; corners, lines and their ends are none.
void leave_out_spikes(Cells& cells) {
  constexpr double kFar = 6.0;     // standard deviations of the noise
  constexpr double kLeast = 0.02;  // of the values' range
  const auto limit = static_cast<float>(std::max(kFar * cells.noise_sd, kLeast));
  std::vector<std::size_t> spikes;
  for (std::int64_t y = 1; y + 1 < cells.height; ++y) {
    mtf::require_going_on();
    for (std::int64_t x = 1; x + 1 < cells.width; ++x) {
      const float v = cells.at(x, y), left = cells.at(x - 1, y), right = cells.at(x + 1, y);
      // Most cells are not far from both of these, with which the others need no comparison.
      if (!(std::abs(v - left) > limit) && !(std::abs(v - right) > limit)) continue;
      int below = 0, above = 0, known = 0;
      for (std::int64_t j = y - 1; j <= y + 1; ++j)
        for (std::int64_t i = x - 1; i <= x + 1; ++i) {
          const float other = cells.at(i, j);
          if (std::isnan(other) || (i == x && j == y)) continue;
          ++known;
          below += v - other > limit ? 1 : 0;
          above += other - v > limit ? 1 : 0;
        }
      if (known >= 5 && std::max(below, above) >= known - 1)
        spikes.push_back(static_cast<std::size_t>(y * cells.width + x));
    }
  }
  for (const std::size_t i : spikes) cells.value[i] = kNone;
}

/// Weighted mean of five neighbours, `step` elements apart, of those that are numbers; `at` is the middle one.
float binomial_mean(const float* middle, std::int64_t at, std::int64_t count, std::int64_t step) {
  float sum = 0.0F, weight = 0.0F;
  for (std::int64_t k = std::max<std::int64_t>(-2, -at); k <= std::min<std::int64_t>(2, count - 1 - at); ++k) {
    const float v = middle[k * step];
    if (std::isnan(v)) continue;
    const float w = kBinomial[static_cast<std::size_t>(k + 2)];
    sum += w * v;
    weight += w;
  }
  return weight > 0.3F ? sum / weight : kNone;
}

std::vector<float> smoothed(const Cells& cells) {
  std::vector<float> rows(cells.value.size()), both(cells.value.size());
  std::size_t i = 0;
  for (std::int64_t y = 0; y < cells.height; ++y) {
    mtf::require_going_on();
    for (std::int64_t x = 0; x < cells.width; ++x, ++i) rows[i] = binomial_mean(&cells.value[i], x, cells.width, 1);
  }
  i = 0;
  for (std::int64_t y = 0; y < cells.height; ++y) {
    mtf::require_going_on();
    for (std::int64_t x = 0; x < cells.width; ++x, ++i) both[i] = binomial_mean(&rows[i], y, cells.height, cells.width);
  }
  return both;
}

/// Cells join a segment while they point within this of its mean direction (of 256 parts: 22.5 degrees) and rise by
/// this share of its strongest cell. After R. Grompone von Gioi et al., LSD: a line segment detector, IPOL 2, 35
/// (2012).
constexpr int kDirectionSpread = 16;
constexpr float kGrowthShare = 0.25F;
/// A ridge is smooth when it lies this close to a parabola, in its own standard deviations across, at least in cells.
constexpr double kSmoothRms = 0.35, kSmoothMax = 1.0;
constexpr double kWidestGap = 3.0;  // along a ridge, in cells

double angle_of(std::uint8_t direction) { return direction * (2.0 * std::numbers::pi / 256.0); }

int difference(std::uint8_t a, int b) {
  return std::abs(static_cast<int>(static_cast<std::int8_t>(a - static_cast<std::uint8_t>(b))));
}

/// True when no neighbour along the gradient is larger.
bool is_ridge(const Gradients& g, std::int64_t x, std::int64_t y) {
  static constexpr std::array<std::array<int, 2>, 4> step{{{1, 0}, {1, 1}, {0, 1}, {-1, 1}}};
  const auto i = static_cast<std::size_t>(y * g.width + x);
  const auto& [dx, dy] = step[static_cast<std::size_t>((g.direction[i] + 16) / 32 % 4)];
  return g.magnitude[i] >= g.at(x + dx, y + dy) && g.magnitude[i] >= g.at(x - dx, y - dy);
}

/// Cells on ridges above the threshold, the largest magnitudes first, in steps of 1/1024 of the largest one.
std::vector<std::uint32_t> seeds_of(const Gradients& g) {
  constexpr std::size_t classes = 1024;
  const float top = *std::max_element(g.magnitude.begin(), g.magnitude.end());
  const auto class_of = [&](float m) {
    return std::min(classes - 1, static_cast<std::size_t>((1.0F - m / top) * static_cast<float>(classes)));
  };
  std::vector<std::uint32_t> found;
  std::array<std::size_t, classes + 1> first{};
  for (std::int64_t y = 1; y + 1 < g.height; ++y) {
    mtf::require_going_on();
    for (std::int64_t x = 1; x + 1 < g.width; ++x)
      if (g.at(x, y) > g.threshold && is_ridge(g, x, y)) {
        found.push_back(static_cast<std::uint32_t>(y * g.width + x));
        ++first[class_of(g.at(x, y)) + 1];
      }
  }
  for (std::size_t k = 1; k <= classes; ++k) first[k] += first[k - 1];
  std::vector<std::uint32_t> sorted(found.size());
  for (const std::uint32_t i : found) sorted[first[class_of(g.magnitude[i])]++] = i;
  return sorted;
}

/// The connected cells around a seed whose gradients have nearly the same direction; they are marked as taken.
struct Blob {
  std::vector<std::uint32_t> cells;
  double x = 0.0, y = 0.0;  ///< sum of their gradients
};

void grow(const Gradients& g, std::uint32_t seed, std::vector<bool>& taken, Blob& blob) {
  blob.cells.assign(1, seed);
  taken[seed] = true;
  const auto gradient = [&](std::uint32_t i) {
    const double angle = angle_of(g.direction[i]);
    return Point{g.magnitude[i] * std::cos(angle), g.magnitude[i] * std::sin(angle)};
  };
  blob.x = gradient(seed).x;
  blob.y = gradient(seed).y;
  const float floor = std::max(static_cast<float>(g.threshold), kGrowthShare * g.magnitude[seed]);
  for (std::size_t next = 0; next < blob.cells.size(); ++next) {
    const std::int64_t x = blob.cells[next] % g.width, y = blob.cells[next] / g.width;
    const double mean = std::atan2(blob.y, blob.x) * 256.0 / (2.0 * std::numbers::pi);
    const int direction = static_cast<int>(std::lround(mean)) & 255;
    for (std::int64_t j = std::max<std::int64_t>(0, y - 1); j <= std::min(g.height - 1, y + 1); ++j)
      for (std::int64_t k = std::max<std::int64_t>(0, x - 1); k <= std::min(g.width - 1, x + 1); ++k) {
        const auto i = static_cast<std::uint32_t>(j * g.width + k);
        if (taken[i] || g.magnitude[i] <= floor || difference(g.direction[i], direction) > kDirectionSpread) continue;
        taken[i] = true;
        blob.cells.push_back(i);
        blob.x += gradient(i).x;
        blob.y += gradient(i).y;
      }
  }
}

struct RidgePoint {
  double s = 0.0, u = 0.0;
  double magnitude = 0.0;
  double sd = 0.0;  ///< across, weighted by the gradient
};

/// One point a cell along the blob: place and width across, weighted by the gradient, and the largest gradient.
std::vector<RidgePoint> ridge_of(const Gradients& g, const Blob& blob, const Segment& frame) {
  double low = 0.0, high = 0.0;
  const auto centre = [&](std::uint32_t i) {
    return Point{static_cast<double>(i % g.width) + 0.5, static_cast<double>(i / g.width) + 0.5};
  };
  for (const std::uint32_t i : blob.cells) {
    const double s = frame.along(centre(i));
    low = std::min(low, s);
    high = std::max(high, s);
  }
  struct Sum {
    double weight = 0.0, s = 0.0, u = 0.0, square = 0.0, top = 0.0;
  };
  std::vector<Sum> bins(static_cast<std::size_t>(high - low) + 1);
  for (const std::uint32_t i : blob.cells) {
    const Point p = centre(i);
    const double s = frame.along(p), u = frame.across(p), m = g.magnitude[i];
    Sum& bin = bins[static_cast<std::size_t>(s - low)];
    bin.weight += m;
    bin.s += m * s;
    bin.u += m * u;
    bin.square += m * u * u;
    bin.top = std::max(bin.top, m);
  }
  std::vector<RidgePoint> ridge;
  for (const Sum& bin : bins) {
    if (bin.weight <= 0.0) continue;
    const double u = bin.u / bin.weight;
    ridge.push_back({bin.s / bin.weight, u, bin.top, std::sqrt(std::max(0.0, bin.square / bin.weight - u * u))});
  }
  return ridge;
}

/// Least squares of a parabola, in a scaled variable for the sake of its condition.
std::array<double, 3> parabola(std::span<const RidgePoint> points) {
  const double middle = 0.5 * (points.front().s + points.back().s);
  const double scale = std::max(1.0, 0.5 * (points.back().s - points.front().s));
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  for (const RidgePoint& p : points) {
    const double z = (p.s - middle) / scale;
    const Eigen::Vector3d row(1.0, z, z * z);
    normal += row * row.transpose();
    right += row * p.u;
  }
  const Eigen::Vector3d a = normal.ldlt().solve(right);
  const double c1 = a(1) / scale, c2 = a(2) / (scale * scale);
  return {a(0) - c1 * middle + c2 * middle * middle, c1 - 2.0 * c2 * middle, c2};
}

/// Hands over the smooth pieces of a ridge; where it is not smooth it is cut at its worst point.
void take_pieces(std::span<const RidgePoint> points, const Segment& frame, double min_length, const TakeSegment& take) {
  while (points.size() >= 4 && points.back().s - points.front().s >= min_length) {
    Segment piece = frame;
    piece.coefficient = parabola(points);
    std::size_t worst = 0;
    double largest = 0.0, squares = 0.0, magnitude = 0.0, sd = 0.0;
    for (std::size_t i = 0; i < points.size(); ++i) {
      const double e = std::abs(points[i].u - piece.offset(points[i].s));
      squares += e * e;
      magnitude += points[i].magnitude;
      sd += points[i].sd;
      if (e > largest) largest = e, worst = i;
    }
    const double count = static_cast<double>(points.size());
    const double width = std::max(1.0, sd / count);
    if (std::sqrt(squares / count) <= kSmoothRms * width && largest <= kSmoothMax * width) {
      piece.s0 = points.front().s;
      piece.s1 = points.back().s;
      piece.peak = magnitude / count;
      take(piece);
      return;
    }
    const std::size_t least = 1 + points.size() / 64;  // so that the work stays in proportion
    const std::size_t cut = std::clamp(worst, least, points.size() - least);
    if (cut < points.size() / 2) {
      take_pieces(points.first(cut), frame, min_length, take);
      points = points.subspan(cut);
    } else {
      take_pieces(points.subspan(cut), frame, min_length, take);
      points = points.first(cut);
    }
  }
}

}  // namespace

Cells make_cells(mtf::ImageView<const float> image) {
  Cells cells;
  const double share = valid_share(image);
  if (share < kSparse) cells.size_px = 2;
  const auto count = [&](std::int64_t pixels) { return (pixels + cells.size_px - 1) / cells.size_px; };
  while (count(image.width) * count(image.height) > kMostCells) cells.size_px *= 2;
  cells.width = count(image.width);
  cells.height = count(image.height);
  cells.value.resize(static_cast<std::size_t>(cells.width * cells.height));

  std::vector<double> sum(static_cast<std::size_t>(cells.width));
  std::vector<int> numbers(static_cast<std::size_t>(cells.width));
  float low = std::numeric_limits<float>::max(), high = std::numeric_limits<float>::lowest();
  std::int64_t known = 0;
  double pixels = 0.0;
  for (std::int64_t row = 0; row < cells.height; ++row) {
    mtf::require_going_on();
    std::fill(sum.begin(), sum.end(), 0.0);
    std::fill(numbers.begin(), numbers.end(), 0);
    const std::int64_t end = std::min(image.height, (row + 1) * cells.size_px);
    for (std::int64_t y = row * cells.size_px; y < end; ++y)
      for (std::int64_t x = 0; x < image.width; ++x) {
        const float v = image.at(x, y);
        if (!std::isfinite(v)) continue;
        sum[static_cast<std::size_t>(x / cells.size_px)] += v;
        ++numbers[static_cast<std::size_t>(x / cells.size_px)];
      }
    for (std::int64_t x = 0; x < cells.width; ++x) {
      const auto i = static_cast<std::size_t>(x);
      float& v = cells.value[static_cast<std::size_t>(row * cells.width + x)];
      v = numbers[i] > 0 ? static_cast<float>(sum[i] / numbers[i]) : kNone;
      if (numbers[i] == 0) continue;
      ++known;
      pixels += numbers[i];
      low = std::min(low, v);
      high = std::max(high, v);
    }
  }
  cells.valid = static_cast<double>(known) / static_cast<double>(cells.value.size());
  if (known > 0) {
    constexpr double kWild = 20.0;
    const Range shared = shared_range(cells);
    if (shared.size() > 0.0 && static_cast<double>(high) - static_cast<double>(low) > kWild * shared.size()) {
      low = shared.low;
      high = shared.high;
      for (float& v : cells.value)
        if (!(v >= low && v <= high)) v = kNone;
    }
    cells.range = static_cast<double>(high) - static_cast<double>(low);
    cells.pixels_a_cell = pixels / static_cast<double>(known);
    const double largest = std::max(std::abs(static_cast<double>(low)), std::abs(static_cast<double>(high)));
    cells.rounding = std::numeric_limits<float>::epsilon() * std::max(1.0, largest / cells.range);
    if (cells.range > 0.0)
      for (float& v : cells.value)
        v = static_cast<float>((static_cast<double>(v) - static_cast<double>(low)) / cells.range);
    cells.noise_sd = noise_of(cells);
    if (cells.size_px == 1) leave_out_spikes(cells);
  }
  return cells;
}

Gradients make_gradients(const Cells& cells) {
  const std::vector<float> value = smoothed(cells);
  Gradients gradients;
  gradients.width = cells.width;
  gradients.height = cells.height;
  gradients.magnitude.assign(value.size(), 0.0F);
  gradients.direction.assign(value.size(), 0);
  gradients.threshold = std::max(kNoiseMargin * kGradientNoise * cells.noise_sd, cells.rounding);
  for (std::int64_t y = 1; y + 1 < cells.height; ++y) {
    mtf::require_going_on();
    for (std::int64_t x = 1; x + 1 < cells.width; ++x) {
      const auto i = static_cast<std::size_t>(y * cells.width + x);
      const auto row = static_cast<std::size_t>(cells.width);
      const float gx = 0.5F * (value[i + 1] - value[i - 1]), gy = 0.5F * (value[i + row] - value[i - row]);
      const float magnitude = std::sqrt(gx * gx + gy * gy);
      if (std::isnan(magnitude)) continue;
      gradients.magnitude[i] = magnitude;
      if (magnitude <= gradients.threshold) continue;
      const float turn = std::atan2(gy, gx) / (2.0F * std::numbers::pi_v<float>);
      gradients.direction[i] = static_cast<std::uint8_t>(std::lround(turn * 256.0F) & 255);
    }
  }
  // Cells on the border take the gradient of their inner neighbours.
  if (cells.width < 3 || cells.height < 3) return gradients;
  for (std::int64_t y = 0; y < cells.height; ++y)
    for (std::int64_t x = 0; x < cells.width; ++x) {
      const auto i = static_cast<std::size_t>(y * cells.width + x);
      const auto inner = static_cast<std::size_t>(std::clamp<std::int64_t>(y, 1, cells.height - 2) * cells.width +
                                                  std::clamp<std::int64_t>(x, 1, cells.width - 2));
      gradients.magnitude[i] = gradients.magnitude[inner];
      gradients.direction[i] = gradients.direction[inner];
    }
  return gradients;
}

void make_segments(const Gradients& g, double min_length, const TakeSegment& take) {
  if (g.width < 3 || g.height < 3) return;
  std::vector<bool> taken(g.magnitude.size(), false);
  Blob blob;
  for (const std::uint32_t seed : seeds_of(g)) {
    if (taken[seed]) continue;
    mtf::require_going_on();
    grow(g, seed, taken, blob);
    if (static_cast<double>(blob.cells.size()) < min_length) continue;
    const double size = std::hypot(blob.x, blob.y);
    Segment frame;
    frame.origin = {static_cast<double>(seed % g.width) + 0.5, static_cast<double>(seed / g.width) + 0.5};
    frame.normal = {blob.x / size, blob.y / size};
    const std::vector<RidgePoint> ridge = ridge_of(g, blob, frame);
    for (std::size_t first = 0, i = 1; i <= ridge.size(); ++i)
      if (i == ridge.size() || ridge[i].s - ridge[i - 1].s > kWidestGap) {
        take_pieces(std::span(ridge).subspan(first, i - first), frame, min_length, take);
        first = i;
      }
  }
}

}  // namespace calib::find
