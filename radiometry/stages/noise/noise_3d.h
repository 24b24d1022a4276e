// SPDX-License-Identifier: Apache-2.0
#pragma once

// The seven components of three-dimensional noise: of a cube of frames t, rows v and columns h, the variance of what
// depends on some of the three alone (D'Agostino and Webb, Proc. SPIE 1488, 110 (1991)). A cube is the sum of seven
// independent fields; the estimator is the analysis of variance of that model without repetition, with mean squares
//   MS_tvh = tvh^2,   MS_tv = tvh^2 + H tv^2,   MS_t = tvh^2 + H tv^2 + V th^2 + V H t^2, ...
// solved for the components. So each of them is free of bias for any size of the cube, where averages over a finite
// direction alone would keep a part of the others, tvh^2 / H in tv^2, and lose (n - 1) / n of their own.

#include <vector>

#include "radiometry/fields.h"
#include "radiometry/stages/noise/noise.h"

namespace radiometry {

/// rms of each component, in the unit of the image; electrons, where it comes from a sensor file.
struct Noise3d {
  double t = 0.0, v = 0.0, h = 0.0, tv = 0.0, th = 0.0, vh = 0.0, tvh = 0.0;

  double total() const;  ///< root sum of squares

  static constexpr auto fields() {
    using T = Noise3d;
    constexpr auto row = [](double Noise3d::*member, std::string_view name, std::string_view doc) {
      return optional(member, name, "e-", 0.0, 1e30, "\"20 e-\"", doc);
    };
    return std::tuple{
        row(&T::t, "t", "flicker of whole frames, rms"),     row(&T::v, "v", "fixed noise of rows, rms"),
        row(&T::h, "h", "fixed noise of columns, rms"),      row(&T::tv, "tv", "temporal noise of rows, rms"),
        row(&T::th, "th", "temporal noise of columns, rms"), row(&T::vh, "vh", "fixed noise of pixels, rms"),
        row(&T::tvh, "tvh", "temporal noise of pixels, rms")};
  }
};

/// Adds the noise of one frame; the number of the frame is in the key. Throws UsageError for components out of bounds.
void add_noise_3d(mtf::ImageView<float> image, const Noise3d& noise, const NoiseKey& key, Origin origin = {},
                  int threads = 1);

/// Takes the frames of a cube one by one and keeps only sums of them.
class Noise3dEstimator {
 public:
  /// Throws UsageError for fewer than two rows or columns.
  Noise3dEstimator(std::int64_t width, std::int64_t height);

  /// A frame of that size without NaN or infinities; UsageError for others.
  void add(mtf::ImageView<const float> frame);

  /// Variances without bias, in the order of Noise3d; those of components that are small or 0 may be negative.
  /// Throws UsageError with fewer than two frames.
  Noise3d variances() const;
  /// Their roots, 0 for negative ones.
  Noise3d estimate() const;

 private:
  std::int64_t width_, height_;
  double shift_ = 0.0;  ///< the mean of the first frame: sums of squares are taken about it
  double squares_ = 0.0;
  std::vector<double> pixel_;    ///< sums over t
  std::vector<double> frame_;    ///< sums over v and h, a number a frame
  double row_squares_ = 0.0;     ///< of the sums over h, summed over t and v
  double column_squares_ = 0.0;  ///< of the sums over v
};

}  // namespace radiometry
