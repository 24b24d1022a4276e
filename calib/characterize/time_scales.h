// SPDX-License-Identifier: Apache-2.0
#pragma once

// The noise of pixels by the time over which it changes. Of the scale j = 0, 1, 2 ... are the differences
//   d = (sum of 2^j frames - sum of the 2^j frames after them) / sqrt(2^(j + 1))
// of stretches that do not overlap, T/2^(j + 1) of them in T frames: Haar's orthonormal wavelets. The mean of d^2 is
// the variance of white noise at every scale, that of 1/f noise about doubles from one to the next; both nearly without
// correlation between differences (G. W. Wornell, Signal Processing with Fractals, 1996). A frame that is added costs
// two differences on average, and the memory is that of two numbers a scale for each pixel that is looked at.

#include <cstdint>
#include <span>
#include <vector>

namespace calib {

class TimeScales {
 public:
  explicit TimeScales(std::int64_t pixels = 0) : pixels_(pixels) {}

  /// Makes room for that many frames in all.
  void reserve(std::int64_t frames);
  /// The values of pixels from the `first` on, in frame t = 0, 1 ... of those reserved. Other pixels may be added at
  /// the same time.
  void add(std::int64_t first, std::span<const double> values, std::int64_t t);
  /// Sums of d^2 of each pixel, a vector a scale, of those that have a difference in that many frames.
  std::vector<std::vector<float>> squares(std::int64_t frames) const;

 private:
  std::int64_t pixels_;
  std::vector<std::vector<float>> sums_{}, squares_{};  ///< of the latest stretch that waits for the next
};

/// The same, as kept of a stack.
struct NoiseScales {
  std::vector<std::vector<float>> pixels{};  ///< sums of d^2, those of every `rows_apart`-th row
  std::vector<double> frame{};               ///< of the means of frames
  std::int64_t frames = 0, rows_apart = 1;

  bool empty() const { return pixels.empty(); }
  std::size_t pixel_count() const { return pixels.front().size(); }
  double differences(std::size_t scale) const { return static_cast<double>(frames >> (scale + 1)); }
  /// Of all scales: the temporal variance of a pixel whose noise is white.
  double variance(std::size_t pixel) const;
};

}  // namespace calib
