// SPDX-License-Identifier: Apache-2.0
#pragma once

// Spectra of fixed patterns, as EMVA 1288 (release 4, section 8) shows them: the periodograms of all rows, or of all
// columns, averaged,
//   P_k = mean over the rows of |sum over x of p(x) exp(-2 pi i k x / n)|^2 / n,   k/n cycles per pixel
// A white pattern has its variance at every frequency; the mean of each row, at k = 0, is left out.
//
// Spectra of the noise in time: the periodograms of the values of a pixel in successive frames, averaged over pixels,
// and that of the means of frames,
//   P_k = |sum over t of x(t) exp(-2 pi i k t / T)|^2 / T,   k/T cycles per frame
// White noise has its variance at every frequency. 1/f noise and lag rise towards low ones, a lamp that flickers
// regularly is a peak. The pixels are about 1024, in all columns and rows where these are fewer. Of more than 1024
// frames the spectra are averages over whole runs of 1024, so that the memory is 4 MB for any number.
//
// The noise of pixels by the time over which it changes. Of the scale j = 0, 1, 2 ... are the differences
//   d = (sum of 2^j frames - sum of the 2^j frames after them) / sqrt(2^(j + 1))
// of stretches that do not overlap, T/2^(j + 1) of them in T frames: Haar's orthonormal wavelets. The mean of d^2 is
// the variance of white noise at every scale, that of 1/f noise about doubles from one to the next; both nearly without
// correlation between differences (G. W. Wornell, Signal Processing with Fractals, 1996). A frame that is added costs
// two differences on average, and the memory is that of two numbers a scale for each pixel that is looked at.

#include <cstdint>
#include <span>
#include <vector>

#include "mtf/image.h"

namespace calib {

enum class LineAxis { rows, columns };

/// P_1 to P_(n/2).
std::vector<double> line_spectrum(mtf::ImageView<const float> plane, LineAxis axis);

struct TimeSpectra {
  std::int64_t length = 0, runs = 0;  ///< T, and how many of them
  std::int64_t of_pixels = 0;         ///< how many
  std::vector<double> pixels, means;  ///< P_1 to P_(T/2), counts^2
};

/// The frames that the spectra are of.
class TimeSeries {
 public:
  TimeSeries(std::int64_t width, std::int64_t height);
  /// `mean`: of the frame, about any number that is the same for all.
  void add(mtf::ImageView<const float> frame, double mean);
  TimeSpectra spectra() const;

 private:
  void take_run(TimeSpectra& sum) const;

  std::vector<std::int64_t> places_;  ///< of the pixels, along rows
  std::vector<float> first_;          ///< their values in the first frame, which are taken from all
  std::vector<float> run_;            ///< of each frame of the run those of the pixels, then the mean
  TimeSpectra sum_;                   ///< over the runs that are whole
};

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
