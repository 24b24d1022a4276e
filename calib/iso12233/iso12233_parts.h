// SPDX-License-Identifier: Apache-2.0
#pragma once

// The steps of iso12233.h. Rows and columns are of the region as turned, counted from 0. Where the reference program
// has a peculiarity (ends of differences, an index off by one, a rounded width), published figures contain it, so it is
// kept and named.

#include <array>
#include <cstdint>
#include <vector>

#include "calib/edge/edge_curve.h"
#include "mtf/image.h"

namespace calib::iso {

/// The region, turned by a quarter against the clock where its edge is closer to horizontal.
struct Region {
  mtf::ImageView<const float> image;
  Roi roi;
  bool turned = false;

  std::int64_t rows() const { return turned ? roi.width : roi.height; }
  std::int64_t columns() const { return turned ? roi.height : roi.width; }
  double at(std::int64_t row, std::int64_t column) const {
    return turned ? image.at(roi.x + roi.width - 1 - row, roi.y + column) : image.at(roi.x + column, roi.y + row);
  }
};

/// The edge is taken as horizontal when the third rows from both ends differ more than the third columns. At least 4
/// pixels a side.
Region turn_upright(mtf::ImageView<const float> image, const Roi& roi);

/// Column of the edge, a polynomial in z = (row - mean) / sd of the rows 0 .. rows - 1.
class RowPolynomial {
 public:
  RowPolynomial() = default;
  /// Least squares through `column`, one a row, more rows than `order`.
  RowPolynomial(const std::vector<double>& column, int order);
  double operator()(double row) const;
  double slope(double row) const;

 private:
  double mean_ = 0.0, sd_ = 1.0;
  std::array<double, 6> coefficient_{};
};

struct EdgeFit {
  RowPolynomial curve, line;
  double rms_px = 0.0;  ///< NaN when a row has no gradient at all
};

/// Through the centroids of the rows' windowed differences, twice: the second time windows are centred on the first
/// fit.
EdgeFit fit_edge(const Region& region, int order, bool tukey);

/// Rows that make whole cycles of the phase; 0 when the edge drifts by less than a column.
std::int64_t whole_cycles(std::int64_t rows, double slope);

struct Profile {
  std::vector<double> esf;      ///< 4 a column; empty when the curve is too steep to be projected along
  std::int64_t empty_bins = 0;  ///< filled from their neighbours
};

/// Averages of the first `rows` rows in bins of a quarter column along the curve.
Profile project(const Region& region, std::int64_t rows, const RowPolynomial& curve);

/// columns + 1 samples, 1 / columns cycles per column apart, of an edge function that rises. Empty when no line spread
/// remains within the window.
std::vector<double> response(const std::vector<double>& esf, bool tukey);

/// Windows of n samples numbered from 1 with their maximum near `centre`, falling to both ends at the pace of the
/// longer side. Tukey with alpha = 1: a raised cosine over round(2 x longer side) samples, cut at the far end. Hamming:
/// its centre lies half a sample later.
std::vector<double> tukey_window(std::int64_t n, double centre);
std::vector<double> hamming_window(std::int64_t n, double centre);

}  // namespace calib::iso
