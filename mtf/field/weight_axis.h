// SPDX-License-Identifier: Apache-2.0
#pragma once

// Weights over the image as values on a grid with cubics between them: along an axis its pixels, or 161 places spread
// over them where they are more.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>

namespace mtf {

/// The weights of Lagrange's cubic through values at -1, 0, 1, 2.
inline std::array<double, 4> cubic_weights(double t) {
  return {-t * (t - 1.0) * (t - 2.0) / 6.0, (t + 1.0) * (t - 1.0) * (t - 2.0) / 2.0, -(t + 1.0) * t * (t - 2.0) / 2.0,
          (t + 1.0) * t * (t - 1.0) / 6.0};
}

class WeightAxis {
 public:
  WeightAxis() = default;
  explicit WeightAxis(std::int64_t pixels)
      : nodes_(static_cast<std::size_t>(std::clamp(pixels, kLeast, kMost))),
        step_(pixels > kMost ? static_cast<double>(pixels - 1) / static_cast<double>(kMost - 1) : 1.0) {}

  std::size_t nodes() const { return nodes_; }
  double pixel(std::size_t node) const { return step_ * static_cast<double>(node); }

  /// The value between four nodes.
  struct Cubic {
    std::size_t first;
    std::array<float, 4> weight;
    float of(std::span<const float> values) const {
      const float* const v = values.data() + first;
      return weight[0] * v[0] + weight[1] * v[1] + weight[2] * v[2] + weight[3] * v[3];
    }
  };
  Cubic at(double pixel) const {
    const double position = pixel / step_;
    const double first = std::clamp(std::floor(position) - 1.0, 0.0, static_cast<double>(nodes_ - 4));
    const std::array<double, 4> w = cubic_weights(position - first - 1.0);
    return {static_cast<std::size_t>(first),
            {static_cast<float>(w[0]), static_cast<float>(w[1]), static_cast<float>(w[2]), static_cast<float>(w[3])}};
  }

 private:
  static constexpr std::int64_t kLeast = 4, kMost = 161;
  std::size_t nodes_ = 0;
  double step_ = 1.0;  ///< pixels
};

}  // namespace mtf
