// SPDX-License-Identifier: Apache-2.0
#pragma once

// Analysis of variance of a cube of frames t, rows v and columns h without repetition: seven mean squares, which for
// normal noise are independent, MS dof / E(MS) being chi-square with dof degrees of freedom (H. Scheffe, The Analysis
// of Variance, Wiley 1959, ch. 4 and 7). A component of three-dimensional noise (noise_3d.h) is a sum of them with
// signs:
//   tv = (MS_tv - MS_tvh) / H,   t = (MS_t - MS_tv - MS_th + MS_tvh) / (V H),   tvh = MS_tvh, ...

#include <array>
#include <cstddef>

namespace radiometry {

/// The places of the seven in arrays, in the order of Noise3d.
enum CubePart : std::size_t { kT, kV, kH, kTv, kTh, kVh, kTvh };
inline constexpr std::size_t kCubeParts = 7;

/// Row c: the signs of the mean squares in component c.
inline constexpr std::array<std::array<int, kCubeParts>, kCubeParts> kCubeSigns{{{1, 0, 0, -1, -1, 0, 1},
                                                                                 {0, 1, 0, -1, 0, -1, 1},
                                                                                 {0, 0, 1, 0, -1, -1, 1},
                                                                                 {0, 0, 0, 1, 0, 0, -1},
                                                                                 {0, 0, 0, 0, 1, 0, -1},
                                                                                 {0, 0, 0, 0, 0, 1, -1},
                                                                                 {0, 0, 0, 0, 0, 0, 1}}};

/// Squares of the sums over the directions that are left out of a name, added up, over the number of values in a sum:
/// by_tv = sum over t and v of (sum over h)^2 / H. The values are about any reference, best near their mean.
struct CubeSquares {
  double frames = 0.0, rows = 0.0, columns = 0.0;
  long double all = 0.0L, t = 0.0L, v = 0.0L, h = 0.0L, tv = 0.0L, th = 0.0L, vh = 0.0L, tvh = 0.0L;
};

struct MeanSquares {
  double frames = 0.0, rows = 0.0, columns = 0.0;
  std::array<double, kCubeParts> value{};

  double dof(std::size_t part) const {
    const double a = frames - 1.0, b = rows - 1.0, c = columns - 1.0;
    return std::array{a, b, c, a * b, a * c, b * c, a * b * c}[part];
  }
  /// By which the signed sum of a component is divided.
  double divisor(std::size_t part) const {
    return std::array{rows * columns, frames * columns, frames * rows, columns, rows, frames, 1.0}[part];
  }
  /// Without bias; that of a component that is small or 0 may be negative.
  double variance(std::size_t part) const {
    double sum = 0.0;
    for (std::size_t q = 0; q < kCubeParts; ++q) sum += kCubeSigns[part][q] * value[q];
    return sum / divisor(part);
  }
};

inline MeanSquares mean_squares(const CubeSquares& by) {
  MeanSquares result{.frames = by.frames, .rows = by.rows, .columns = by.columns};
  const std::array sums{by.t - by.all,
                        by.v - by.all,
                        by.h - by.all,
                        by.tv - by.t - by.v + by.all,
                        by.th - by.t - by.h + by.all,
                        by.vh - by.v - by.h + by.all,
                        by.tvh - by.tv - by.th - by.vh + by.t + by.v + by.h - by.all};
  for (std::size_t q = 0; q < kCubeParts; ++q) result.value[q] = static_cast<double>(sums[q]) / result.dof(q);
  return result;
}

}  // namespace radiometry
