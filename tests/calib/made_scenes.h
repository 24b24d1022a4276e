// SPDX-License-Identifier: Apache-2.0
#pragma once

// Scenes of squares with known sides, blurred by a Gaussian: the product of two slits' step pairs, exact for any
// rotation.

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <random>
#include <vector>

#include "calib/edge/edge_curve.h"
#include "mtf/image.h"

namespace calib::test {

struct Square {
  Point centre;
  double half_px = 40.0;
  double angle_deg = 0.0;
  double step = -0.6;  ///< inside less outside
};

struct Side {
  Point from, to;
};

inline Point corner(const Square& square, int k) {
  const double angle = (square.angle_deg + 45.0 + 90.0 * k) * std::numbers::pi / 180.0;
  const double radius = square.half_px * std::numbers::sqrt2;
  return {square.centre.x + radius * std::cos(angle), square.centre.y + radius * std::sin(angle)};
}

inline std::vector<Side> sides_of(const std::vector<Square>& squares) {
  std::vector<Side> sides;
  for (const Square& square : squares)
    for (int k = 0; k < 4; ++k) sides.push_back({corner(square, k), corner(square, k + 1)});
  return sides;
}

/// The image of squares on a background, with white noise.
inline mtf::Image made_scene(std::int64_t width, std::int64_t height, const std::vector<Square>& squares,
                             double noise_sd = 0.0, double background = 0.8, double blur_px = 0.7) {
  mtf::Image image(width, height);
  std::mt19937 random(7);
  std::normal_distribution<double> normal;
  const auto within = [&](double d, double half) {
    const double scale = 1.0 / (blur_px * std::numbers::sqrt2);
    return 0.5 * (std::erf((d + half) * scale) - std::erf((d - half) * scale));
  };
  for (std::int64_t y = 0; y < height; ++y)
    for (std::int64_t x = 0; x < width; ++x) {
      double value = background;
      for (const Square& square : squares) {
        const double dx = static_cast<double>(x) + 0.5 - square.centre.x;
        const double dy = static_cast<double>(y) + 0.5 - square.centre.y;
        if (std::hypot(dx, dy) > 1.5 * square.half_px + 10.0 * blur_px) continue;
        const double c = std::cos(square.angle_deg * std::numbers::pi / 180.0);
        const double s = std::sin(square.angle_deg * std::numbers::pi / 180.0);
        value += square.step * within(c * dx + s * dy, square.half_px) * within(c * dy - s * dx, square.half_px);
      }
      image.at(x, y) = static_cast<float>(value + noise_sd * normal(random));
    }
  return image;
}

/// Adds a rectangle. Only the pixels around it are visited, so that thousands of rectangles take little time.
inline void add_rectangle(mtf::Image& image, Point centre, double half_x_px, double half_y_px, double angle_deg,
                          double step, double blur_px = 0.7) {
  const double c = std::cos(angle_deg * std::numbers::pi / 180.0), s = std::sin(angle_deg * std::numbers::pi / 180.0);
  const double scale = 1.0 / (blur_px * std::numbers::sqrt2);
  const double far_px = std::hypot(half_x_px, half_y_px) + 10.0 * blur_px;
  const auto within = [&](double d, double half) {
    return 0.5 * (std::erf((d + half) * scale) - std::erf((d - half) * scale));
  };
  const auto first = [](double at) { return std::max<std::int64_t>(0, static_cast<std::int64_t>(at)); };
  const auto end = [](double at, std::int64_t size) { return std::min(size, static_cast<std::int64_t>(at) + 1); };
  for (std::int64_t y = first(centre.y - far_px); y < end(centre.y + far_px, image.height()); ++y)
    for (std::int64_t x = first(centre.x - far_px); x < end(centre.x + far_px, image.width()); ++x) {
      const double dx = static_cast<double>(x) + 0.5 - centre.x, dy = static_cast<double>(y) + 0.5 - centre.y;
      image.at(x, y) +=
          static_cast<float>(step * within(c * dx + s * dy, half_x_px) * within(c * dy - s * dx, half_y_px));
    }
}

/// Length of a side inside a region.
inline double length_inside(const Side& side, const Roi& roi) {
  double from = 0.0, to = 1.0;
  const auto cut = [&](double start, double step, double low, double high) {
    if (std::abs(step) < 1e-12) {
      if (start <= low || start >= high) to = -1.0;
      return;
    }
    const double a = (low - start) / step, b = (high - start) / step;
    from = std::max(from, std::min(a, b));
    to = std::min(to, std::max(a, b));
  };
  const double x = static_cast<double>(roi.x), y = static_cast<double>(roi.y);
  cut(side.from.x, side.to.x - side.from.x, x, x + static_cast<double>(roi.width));
  cut(side.from.y, side.to.y - side.from.y, y, y + static_cast<double>(roi.height));
  return std::max(0.0, to - from) * std::hypot(side.to.x - side.from.x, side.to.y - side.from.y);
}

}  // namespace calib::test
