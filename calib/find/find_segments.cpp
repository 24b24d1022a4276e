// SPDX-License-Identifier: Apache-2.0
#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>

#include "calib/find/find_parts.h"
#include "mtf/work/stop.h"

namespace calib::find {
namespace {

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
