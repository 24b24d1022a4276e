// SPDX-License-Identifier: Apache-2.0
#pragma once

// What lies beyond the edge of an image. The canvas on which a plan is defined is periodic:
//   reflect    half-sample mirror dcba|abcd|dcba, period 2N (works at 1 px)
//   replicate  the edge sample held for one image size beyond each side, period 3N
//   constant   a given value for one image size beyond each side, period 3N
//   periodic   the image itself, period N

#include <algorithm>
#include <array>
#include <cstdint>
#include <string_view>

namespace mtf {

enum class Border { reflect, replicate, constant, periodic };
inline constexpr std::array<std::string_view, 4> kBorderNames{"reflect", "replicate", "constant", "periodic"};

/// Canvas length of an image of n samples.
inline std::int64_t canvas_length(Border border, std::int64_t n) {
  return border == Border::periodic ? n : border == Border::reflect ? 2 * n : 3 * n;
}

/// Sample of the image (0..n-1) that stands at position i (any sign) of the canvas; -1 for that of a constant border.
inline std::int64_t border_source(Border border, std::int64_t i, std::int64_t n) {
  const auto modulo = [](std::int64_t a, std::int64_t m) { return (a % m + m) % m; };
  switch (border) {
    case Border::periodic:
      return modulo(i, n);
    case Border::reflect: {
      const std::int64_t j = modulo(i, 2 * n);
      return j < n ? j : 2 * n - 1 - j;
    }
    case Border::replicate:
      return std::clamp<std::int64_t>(modulo(i + n, 3 * n) - n, 0, n - 1);
    case Border::constant: {
      const std::int64_t j = modulo(i, 3 * n);
      return j < n ? j : -1;
    }
  }
  return -1;
}

}  // namespace mtf
