// SPDX-License-Identifier: Apache-2.0
#pragma once

// Fixed patterns: the variances over pixels, rows and columns of what does not change from frame to frame. A plane, the
// mean frame of a stack or the difference of two, holds the pattern, what is left of temporal noise after T frames, and
// the part of the rounding error that is fixed (rounding.h). Its three mean squares, about the row and column means,
// are those of an analysis of variance; what is temporal is subtracted:
//   pixels   MS_pixel - sum MS_tvh/T - sum R
//   rows     (MS_row - MS_pixel - sum (MS_tv - MS_tvh)/T) / H,   columns with V and MS_th
// the sums over the stacks in the plane. Without that, temporal row noise / T is taken for a pattern of rows (EMVA 1288
// subtracts the pixels' noise only). Defects, pixels beyond 4.5 robust standard deviations, take no part: rows and
// columns are fitted again without them, and the variance of the rest is divided by that of a normal distribution cut
// there.
//
// Shading: what changes slowly over a plane, as the light of a lamp, or vignetting, beside a sensor's own pattern. It
// is a polynomial of a stated degree n, all x^i y^j with 1 <= i + j <= n, fitted by least squares to the pixels within
// 4.5 robust standard deviations of it. Polynomials that are orthonormal on the pixels of an axis (Gram, by recurrence)
// make each coefficient a sum over the plane. Of white pixels the fit takes as many squares as it has terms, and no
// more: n along y from those of the rows, n along x from the columns, n (n - 1) / 2 from the pixels. (The high-pass of
// 5 x 5 pixels of EMVA 1288 takes 4 % of white pixels and 20 % of rows and columns.)

#include <functional>
#include <set>
#include <string>
#include <vector>

#include "calib/characterize/components.h"
#include "mtf/image.h"

namespace calib {

struct Defect {
  std::int64_t x = 0, y = 0;
  double excess = 0.0;  ///< counts above its row and column
};

/// 4.5 robust standard deviations of numbers about 0, of at most a million of them: beyond it are defects.
double defect_limit(std::size_t count, const std::function<double(std::size_t)>& number);

/// Mean squares of a plane, each with the expectation of a single plane: pixels alone have the same in all three.
struct PlaneSquares {
  double rows = 0.0, columns = 0.0;  ///< V, H
  double pixel = 0.0, row = 0.0, column = 0.0;
  double pixel_dof = 0.0, row_dof = 0.0, column_dof = 0.0;
  double far = 0.0;                             ///< deviation from which on a pixel is a defect
  double skewness = 0.0, kurtosis = 0.0;        ///< of the pixels that are no defects; 0 and 3 are normal
  std::vector<Defect> defects;                  ///< along rows
  std::vector<double> row_means, column_means;  ///< without the defects; the columns about the mean

  /// Of a pixel from its row and column.
  double deviation(mtf::ImageView<const float> plane, std::int64_t x, std::int64_t y) const {
    return static_cast<double>(plane.row(y)[x]) - row_means[static_cast<std::size_t>(y)] -
           column_means[static_cast<std::size_t>(x)];
  }
};
/// `trend`: degree of the one that was removed from the plane, which took squares with it.
/// `without`: places along rows of pixels that take no part, as defects do.
PlaneSquares plane_squares(mtf::ImageView<const float> plane, int trend = 0,
                           const std::set<std::int64_t>& without = {});

/// Adds a warning where one rms describes these pixels badly, as when they fall into two groups. The limits are a
/// skewness of 1 and a kurtosis of 2 and 5, on planes so small that chance passes these five of its standard
/// deviations.
void warn_of_shape(const std::string& name, const PlaneSquares& plane, std::vector<std::string>& warnings);

/// A stack whose mean frame is in the plane.
struct AveragedStack {
  radiometry::MeanSquares squares;
  double pattern = 0.0;     ///< R, and what slow noise moves its pixels by beyond MS_tvh/T (slow_noise.h), counts^2
  double pattern_sd = 0.0;  ///< of that
};

struct Pattern {
  VarianceComponent pixel, row, column;  ///< in the unit of the plane, squared; of the process of which this is a draw
  /// Standard deviations of the same variances as numbers of this one sensor: temporal noise alone.
  double pixel_sd_array = 0.0, row_sd_array = 0.0, column_sd_array = 0.0;
};
Pattern pattern_of(const PlaneSquares& plane, const std::vector<AveragedStack>& stacks);

struct Trend {
  int degree = 0;        ///< what was fitted: lower than asked for where an axis has fewer than 8 pixels a degree
  double rows = 0.0;     ///< sum of the squares of the coefficients of y alone,
  double columns = 0.0;  ///< of x alone,
  double cross = 0.0;    ///< and of both, in the unit of the plane squared: sums over the pixels
  int cross_terms() const { return degree * (degree - 1) / 2; }
};

/// Subtracts it from the plane, whose mean stays.
Trend remove_trend(mtf::ImageView<float> plane, int degree);

/// Rms of a pattern.
struct PatternRms {
  double pixel = 0.0, row = 0.0, column = 0.0;
};
/// The pattern without the mean of the pixels that are no defects, as a map: what a plane shows is larger by what is
/// left of temporal noise, so the deviations of pixels, rows and columns are each shrunk to the rms that was found.
/// Defects stay as they are.
mtf::Image pattern_map(mtf::ImageView<const float> plane, const PlaneSquares& squares, const PatternRms& found);

}  // namespace calib
