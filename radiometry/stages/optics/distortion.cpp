// SPDX-License-Identifier: Apache-2.0
#include "radiometry/stages/optics/distortion.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "mtf/parallel.h"

namespace radiometry {
namespace {

using mtf::UsageError;

constexpr std::int64_t kRowsAtOnce = 8;
constexpr int kStarts = 256;

/// d r' / d r at s = r^2.
double slope(const Distortion& d, double s) { return 1.0 + s * (3.0 * d.k1 + s * (5.0 * d.k2 + s * 7.0 * d.k3)); }

/// The r^2 at which r' stops rising; infinity where it never does. The slope is monotone between its extremes.
double fold(const Distortion& d) {
  const double a = 21.0 * d.k3, b = 10.0 * d.k2, c = 3.0 * d.k1;
  const double root = std::sqrt(std::max(0.0, b * b - 4.0 * a * c));
  const double q = -0.5 * (b + std::copysign(root, b));
  std::array<double, 3> ends{q / a, c / q, 1.0};
  for (double& end : ends)
    if (!(end > 0.0 && std::isfinite(end))) end = 1.0;
  std::sort(ends.begin(), ends.end());
  double low = 0.0, high = ends[0];
  std::size_t next = 1;
  while (slope(d, high) > 0.0) {
    low = high;
    high = next < ends.size() ? ends[next++] : 2.0 * high;
    if (high > 1e30) return std::numeric_limits<double>::infinity();
  }
  for (int i = 0; i < 200 && high - low > 1e-15 * high; ++i) {
    const double middle = 0.5 * (low + high);
    (slope(d, middle) > 0.0 ? low : high) = middle;
  }
  return low;
}

/// Keys' cubic convolution at a fraction t of the distance from the second sample to the third.
std::array<double, 4> keys_taps(double t) {
  return {t * (-0.5 + t * (1.0 - 0.5 * t)), 1.0 + t * t * (-2.5 + 1.5 * t), t * (0.5 + t * (2.0 - 1.5 * t)),
          t * t * (-0.5 + 0.5 * t)};
}

class Scene {
 public:
  Scene(mtf::ImageView<const float> samples, mtf::Border rule, double beyond)
      : image_(samples), border_(rule), level_(beyond) {}

  /// Value at a place counted in samples, whole numbers at their centres.
  double at(double x, double y) const {
    const double left = std::floor(x), above = std::floor(y);
    const std::array<double, 4> across = keys_taps(x - left), down = keys_taps(y - above);
    const auto x0 = static_cast<std::int64_t>(left) - 1, y0 = static_cast<std::int64_t>(above) - 1;
    const bool inside = x0 >= 0 && y0 >= 0 && x0 + 4 <= image_.width && y0 + 4 <= image_.height;
    if (!inside || x == left || y == above) return at_edge(across, down, x0, y0);
    const float* row = image_.row(y0) + x0;
    double sum = 0.0;
    for (const double weight : down) {
      double value = 0.0;
      for (std::size_t i = 0; i < 4; ++i) value += across[i] * static_cast<double>(row[i]);
      sum += weight * value;
      row += image_.stride;
    }
    return sum;
  }

 private:
  /// The same near an edge, and where a sample has no weight: that sample is not read, so that a NaN does not spread
  /// where nothing moves.
  double at_edge(const std::array<double, 4>& across, const std::array<double, 4>& down, std::int64_t x0,
                 std::int64_t y0) const {
    std::array<std::int64_t, 4> columns{};
    for (std::size_t i = 0; i < 4; ++i)
      columns[i] = mtf::border_source(border_, x0 + static_cast<std::int64_t>(i), image_.width);
    double sum = 0.0;
    for (std::size_t j = 0; j < 4; ++j) {
      if (down[j] == 0.0) continue;
      const std::int64_t row = mtf::border_source(border_, y0 + static_cast<std::int64_t>(j), image_.height);
      double value = 0.0;
      for (std::size_t i = 0; i < 4; ++i)
        if (across[i] != 0.0)
          value += across[i] * (row < 0 || columns[i] < 0 ? level_ : static_cast<double>(image_.at(columns[i], row)));
      sum += down[j] * value;
    }
    return sum;
  }

  mtf::ImageView<const float> image_;
  mtf::Border border_;
  double level_;
};

}  // namespace

double distorted_part(const Distortion& d, double r) {
  const double s = r * r;
  return 1.0 + s * (d.k1 + s * (d.k2 + s * d.k3));
}

UndistortedRadius::UndistortedRadius(const Distortion& distortion, double most)
    : distortion_(distortion), most_(std::max(most, 1e-30)), limit_(most_) {
  require_valid("distortion", distortion);
  if (!(most >= 0.0 && most <= 1e15))
    throw UsageError("distortion: an image that reaches " + mtf::format_double(most) +
                     " half diagonals from the axis; it has to be from 0 to 1e15");
  const double end = std::sqrt(fold(distortion));
  const auto reaches = [&](double r) { return r * distorted_part(distortion, r) >= most; };
  while (limit_ < end && limit_ < 1e15 && !reaches(limit_)) limit_ *= 2.0;
  limit_ = std::min(limit_, end);
  if (!reaches(limit_))
    throw UsageError("distortion: k1 = " + mtf::format_double(distortion.k1) +
                     ", k2 = " + mtf::format_double(distortion.k2) + ", k3 = " + mtf::format_double(distortion.k3) +
                     " fold the field over at " + mtf::format_double(limit_ * distorted_part(distortion, limit_)) +
                     " half diagonals, and the image reaches " + mtf::format_double(most) +
                     "; the radius has to rise up to there");
  for (int i = 0; i <= kStarts; ++i) start_.push_back(solve(most_ * i / kStarts, most_ * i / kStarts));
}

double UndistortedRadius::solve(double distorted, double start) const {
  // Newton's method between ends that always hold the root.
  double low = 0.0, high = limit_, r = std::min(start, limit_);
  for (int i = 0; i < 100; ++i) {
    const double miss = r * distorted_part(distortion_, r) - distorted;
    (miss > 0.0 ? high : low) = r;
    double next = r - miss / slope(distortion_, r * r);
    if (!(next >= low && next <= high)) next = 0.5 * (low + high);
    const bool done = std::abs(next - r) <= 1e-15 * r;
    r = next;
    if (done) break;
  }
  return r;
}

double UndistortedRadius::part(double distorted) const {
  if (distorted == 0.0) return 1.0;
  const double place = std::min(distorted / most_, 1.0) * kStarts;
  const auto i = std::min(static_cast<std::size_t>(place), start_.size() - 2);
  const double t = place - static_cast<double>(i);
  return solve(distorted, start_[i] + t * (start_[i + 1] - start_[i])) / distorted;
}

void distort(mtf::ImageView<const float> scene, const Distortion& distortion, const FocalPlane& grid,
             mtf::ImageView<float> out, Origin origin, mtf::Border border, float border_value, int threads) {
  require_region(grid, origin, out.width, out.height);
  if (scene.width != grid.columns || scene.height != grid.rows)
    throw UsageError("distortion: a scene of " + size_of(scene.width, scene.height) + " samples for a grid of " +
                     size_of(grid.columns, grid.rows) + "; light comes from all of it, give the whole scene");
  const double scale = 1.0 / grid.half_diagonal_um();
  const double far_x = std::max(std::abs(grid.x_um(0)), std::abs(grid.x_um(grid.columns - 1)));
  const double far_y = std::max(std::abs(grid.y_um(0)), std::abs(grid.y_um(grid.rows - 1)));
  const UndistortedRadius undistorted(distortion, std::hypot(far_x, far_y) * scale);
  const Scene source(scene, border, static_cast<double>(border_value));
  mtf::parallel_for_each(out.height, kRowsAtOnce, threads, [&](std::int64_t y) {
    for (std::int64_t x = 0; x < out.width; ++x) {
      const std::int64_t column = origin.x + x, row = origin.y + y;
      const double x_um = grid.x_um(column), y_um = grid.y_um(row);
      // The distance from this sample's own place, which is exactly 0 without distortion.
      const double shift = undistorted.part(std::hypot(x_um, y_um) * scale) - 1.0;
      out.at(x, y) = static_cast<float>(source.at(static_cast<double>(column) + shift * x_um / grid.step_x_um,
                                                  static_cast<double>(row) + shift * y_um / grid.step_y_um));
    }
  });
}

double distortion_mtf(double frequency_cy_sample) {
  double lowest = 1.0;
  constexpr int kPhases = 64;
  for (int phase = 0; phase <= kPhases; ++phase) {
    const double t = 0.5 * phase / kPhases;
    double re = 0.0, im = 0.0;
    const std::array<double, 4> taps = keys_taps(t);
    for (std::size_t i = 0; i < 4; ++i) {
      const double turn = 2.0 * mtf::kPi * frequency_cy_sample * (static_cast<double>(i) - 1.0 - t);
      re += taps[i] * std::cos(turn);
      im += taps[i] * std::sin(turn);
    }
    lowest = std::min(lowest, std::hypot(re, im));
  }
  return lowest;
}

}  // namespace radiometry
