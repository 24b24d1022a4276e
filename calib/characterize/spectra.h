// SPDX-License-Identifier: Apache-2.0
#pragma once

// Spectra of fixed patterns, as EMVA 1288 (release 4, section 8) shows them: the periodograms of all rows, or of all
// columns, averaged,
//   P_k = mean over the rows of |sum over x of p(x) exp(-2 pi i k x / n)|^2 / n,   k/n cycles per pixel
// A white pattern has its variance at every frequency; the mean of each row, at k = 0, is left out.
//
// The noise of pixels by the time over which it changes. Of the scale j = 0, 1, 2 ... are the differences
//   d = (sum of 2^j frames - sum of the 2^j frames after them) / sqrt(2^(j + 1))
// of stretches that do not overlap, T/2^(j + 1) of them in T frames: Haar's orthonormal wavelets. The mean of d^2 is
// the variance of white noise at every scale, that of 1/f noise about doubles from one to the next; both nearly without
// correlation between differences (G. W. Wornell, Signal Processing with Fractals, 1996). They are the power in the
// octave about 0.35/2^j cycles per frame. A frame that is added costs two differences on average, and the memory is
// that of two numbers a scale for each pixel that is looked at.

#include <cstdint>
#include <span>
#include <vector>

#include "mtf/image.h"

namespace calib {

enum class LineAxis { rows, columns };

/// P_1 to P_(n/2).
std::vector<double> line_spectrum(mtf::ImageView<const float> plane, LineAxis axis);

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
  std::vector<std::vector<float>> pixels{};  ///< sums of d^2, those of every `rows_apart`-th row; may be empty
  std::vector<double> mean{};                ///< of d^2, over those pixels
  std::vector<double> frame{};               ///< sums, of the means of frames
  std::int64_t frames = 0, rows_apart = 1;

  bool empty() const { return pixels.empty(); }
  std::size_t pixel_count() const { return pixels.front().size(); }
  double differences(std::size_t scale) const { return static_cast<double>(frames >> (scale + 1)); }
  /// Of all scales: the temporal variance of a pixel whose noise is white.
  double variance(std::size_t pixel) const;
};

}  // namespace calib
