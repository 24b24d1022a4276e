// SPDX-License-Identifier: Apache-2.0
#pragma once

// The autocorrelation of the residuals of an edge's pixels. Lags are taken ring by ring around zero as long as a ring
// as a whole differs from no correlation. Noise of independent pixels has none; structure, and what a model misses at a
// distance from the edge, is shared by pixels far from each other along the edge too, and is not taken for noise.

#include <vector>

#include "calib/edge/edge_curve.h"

namespace calib {

/// The correlation of two pixels that many columns and rows apart, and how many of the pixels have such a neighbour.
/// The opposite lag has the same.
struct PixelLag {
  int x = 0, y = 0;
  double correlation = 0.0, share = 1.0;
};

/// Values on the grid of the pixels, with a margin so wide that no lag joins the end of a row to the next.
class PixelGrid {
 public:
  static constexpr int kFarthest_px = 10;
  PixelGrid(std::size_t columns, std::size_t rows);

  /// A pixel that is there but whose value does not count.
  void set(std::size_t column, std::size_t row) { present_[row * stride_ + column] = 1.0F; }
  void set(std::size_t column, std::size_t row, double value);

  /// Of the values.
  double count() const { return count_; }
  double mean_square() const { return squares_ / (count_ > 0.0 ? count_ : 1.0); }
  /// Sum of the products of each value with that of its neighbour, and how many there are; y >= 0.
  double products(int x, int y) const { return sum_over_lag(value_, x, y); }
  double value_pairs(int x, int y) const { return sum_over_lag(known_, x, y); }
  /// Pairs of pixels that are there.
  double pixel_pairs(int x, int y) const { return sum_over_lag(present_, x, y); }
  std::size_t columns() const { return stride_ - kFarthest_px; }
  std::size_t rows() const { return size_ / stride_; }
  /// Over all pairs of values in a column, or in a row: the sum of the products, and how many there are.
  struct Pairs {
    double products = 0.0, count = 0.0;
  };
  Pairs pairs_in_lines(bool columns) const;

 private:
  double sum_over_lag(const std::vector<float>& values, int x, int y) const;
  std::size_t stride_ = 0, size_ = 0;
  std::vector<float> value_, known_, present_;
  double count_ = 0.0, squares_ = 0.0;
};

/// What is known of it: the lags of one half plane out to the ring of that number; 0 and no lags where the pixels are
/// independent.
struct PixelCorrelation {
  std::vector<PixelLag> lags;  ///< without shares
  int rings = 0;
  /// Sum of the correlations of a pixel with all, itself included: the variance of a mean of many pixels is that many
  /// times what independent ones have.
  double sum = 1.0;
};
/// `normal` is that of the edge.
PixelCorrelation correlation_of(const PixelGrid& grid, Point normal);

/// What the pixels of a column, or of a row, share further from each other than `rings` and besides what pixels at one
/// distance from the edge do, as a part of their variance: stripes, where each line has an offset of its own. 0 where
/// noise alone shows as much.
double shared_in_lines(const PixelGrid& grid, Point normal, bool columns, int rings);

/// Variance of a pixel, in squared steps between its values and with that of rounding, below which neighbouring pixels
/// round alike: their residuals are then correlated though the noise is not.
inline constexpr double kRoundsAlike_steps2 = 0.25;

/// What neighbouring pixels share of their noise.
struct NoiseCorrelation {
  std::vector<PixelLag> lags;        ///< of one half plane; none: the noise of the pixels is independent
  double margin = 1.0;               ///< by which the correlations count more, as they are estimates
  double columns = 0.0, rows = 0.0;  ///< part of the variance that the pixels of a whole column, of a row share
  bool white() const { return lags.empty(); }
  /// The variance of a mean of many pixels is so many times that of as many independent ones.
  double sum() const;
};
/// The correlation of the noise, from that of the residuals: fitting the plateaus lowers each of the estimated
/// correlations by (sum of all correlations) x (number of fitted terms) / (number of pixels), which is added back.
/// `values`: how many residuals the estimate is made of; `pixels`: how many were fitted.
NoiseCorrelation noise_correlation(const PixelCorrelation& residuals, double values, double pixels);

}  // namespace calib
