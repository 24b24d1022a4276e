// SPDX-License-Identifier: Apache-2.0
#pragma once

// A stack of frames of one scene that does not change, reduced in one pass to sums, whose memory is that of a plane of
// doubles for any number of frames:
//   for each pixel     sum; sum of squares, of frames above two million pixels in some of the rows
//   for each frame     squares of the sums of rows, of columns and of all, added to the totals at once
//   at six lags        sums of the products of pixels that far apart
//   in time            squares of the differences of stretches of 1, 2, 4 ... frames (spectra.h), and of all successive
//                      frames, of some of the rows
// All values are taken about a whole number near their mean, and the sums of counts (whole numbers) are exact. From
// them follow the seven mean squares of three-dimensional noise, and the temporal covariance of neighbours: as
//   sum over t of (x_p - mean_p) (x_q - mean_q) = sum over t of x_p x_q - S_p S_q / T
// needs the sums S of the pixels at the end only, a lag costs one number and no second pass.
//   calib::StackStatistics dark(640, 512, {.low = 0, .high = 16383});
//   for (const mtf::Image& frame : frames) dark.add(frame.view());
//   const radiometry::MeanSquares squares = dark.mean_squares();

#include <array>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "calib/characterize/spectra.h"
#include "mtf/image.h"
#include "radiometry/stages/noise/mean_squares.h"

namespace calib {

/// A pixel and the one `rows` below and `columns` to its right.
struct Lag {
  int rows = 0, columns = 0;
};
inline constexpr std::array kLags{Lag{0, 1}, Lag{1, 0}, Lag{1, 1}, Lag{1, -1}, Lag{0, 2}, Lag{2, 0}};

struct Covariance {
  double value = 0.0;  ///< without bias
  double pairs = 0.0;  ///< of pixels
};

/// Ends of the scale: values there, or beyond, are counted as clipped.
struct CountRange {
  double low = -std::numeric_limits<double>::infinity(), high = std::numeric_limits<double>::infinity();
};

/// Counts a frame.
struct FrameDrift {
  double value = 0.0, sd = 0.0;
};

class StackStatistics {
 public:
  /// Throws UsageError for fewer than two rows or columns.
  StackStatistics(std::int64_t width, std::int64_t height, CountRange range = {});

  /// Several frames at a time are faster, as the sums of a pixel are fetched once for all. The result depends neither
  /// on that nor on the threads. Throws UsageError for a frame of another size, and for NaN and infinite values with
  /// the first place; frames() then counts those before it, and the sums are of no use.
  void add(std::span<const mtf::ImageView<const float>> frames, int threads = 1);
  void add(mtf::ImageView<const float> frame, int threads = 1) { add({&frame, 1}, threads); }

  std::int64_t width() const { return width_; }
  std::int64_t height() const { return height_; }
  std::int64_t frames() const { return frames_; }
  std::int64_t pixels() const { return width_ * height_; }
  double mean() const;
  double pixel_mean(std::int64_t i) const;  ///< i counts along rows
  std::vector<double> frame_means() const;

  /// Both need two frames; UsageError with fewer.
  radiometry::MeanSquares mean_squares() const;
  Covariance covariance(Lag lag) const;  ///< at one of kLags
  /// Temporal variances of the pixels whose squares are kept, those of every rows_apart()-th row.
  std::vector<float> pixel_variances() const;
  std::int64_t rows_apart() const { return every_; }
  /// Of these pixels: correlation of the noise in successive frames, 1 - (mean square of the differences) / (twice the
  /// variance), with 0 for frames of independent noise (J. von Neumann, Ann. Math. Stat. 12, 367 (1941)).
  double frame_correlation() const;
  /// The noise of pixels by the time over which it changes; of frames above half a million pixels in some of the rows.
  NoiseScales noise_scales() const;

  /// Parts of all values that are at the ends of the range.
  double share_low() const { return share(low_); }
  double share_high() const { return share(high_); }
  /// Pixels that are at the lower or at the upper end in all frames, by their places along rows; none where they are
  /// more than kMostStuck of all.
  std::vector<std::int64_t> stuck(bool high) const;
  static constexpr double kMostStuck = 0.01;
  /// The largest power of two that divides all values; 0 where some are not whole. Counts of 12 bits that are stored in
  /// the upper bits of 16 have 16.
  std::uint32_t step() const;
  std::uint32_t bits() const { return bits_; }  ///< that occur in any value, of negative ones the sign
  /// Von Neumann's ratio of the means of frames: the mean square of the difference of successive ones over their
  /// variance, 2 for independent ones, towards 0 for a drift (J. von Neumann, Ann. Math. Stat. 12, 367 (1941)).
  double von_neumann() const;
  /// The slope of a straight line through the means of frames over their numbers, a frame, and its standard deviation
  /// from what lies about the line; 0 and 0 for fewer than four frames.
  FrameDrift drift() const;

 private:
  struct Part;
  double share(std::int64_t count) const;
  std::vector<Part> reduce(std::span<const mtf::ImageView<const float>> frames, int threads);
  void take(std::span<const Part> frame);
  double kept_variance(std::int64_t i) const;

  std::int64_t width_, height_, frames_ = 0, low_ = 0, high_ = 0;
  CountRange range_;
  double reference_ = 0.0;
  std::int64_t every_;                 ///< row has its squares kept
  std::vector<double> sum_, squares_;  ///< of pixels
  std::int64_t scale_every_;           ///< row is in the scales of time
  TimeScales scales_;                  ///< of those pixels
  std::vector<float> before_, steps_;  ///< latest values of the pixels with squares, and squares of their steps
  std::vector<double> frame_sums_;     ///< about the reference
  std::array<long double, kLags.size()> products_{};
  long double total_ = 0.0L, all_squares_ = 0.0L, frame_squares_ = 0.0L, row_squares_ = 0.0L, column_squares_ = 0.0L;
  std::uint32_t bits_ = 0;  ///< that occur in any value
  bool whole_ = true;
};

}  // namespace calib
