// SPDX-License-Identifier: Apache-2.0
#pragma once

// Shading: what changes slowly over a plane, as the light of a lamp, or vignetting, beside a sensor's own pattern. It
// is a polynomial of a stated degree n, all x^i y^j with 1 <= i + j <= n, fitted by least squares to the pixels within
// 4.5 robust standard deviations of it. Polynomials that are orthonormal on the pixels of an axis (Gram, by recurrence)
// make each coefficient a sum over the plane. Of white pixels the fit takes as many squares as it has terms, and no
// more: n along y from those of the rows, n along x from the columns, n (n - 1) / 2 from the pixels. (The high-pass of
// 5 x 5 pixels of EMVA 1288 takes 4 % of white pixels and 20 % of rows and columns.)

#include "mtf/image.h"

namespace calib {

struct Trend {
  int degree = 0;        ///< what was fitted: lower than asked for where an axis has fewer than 8 pixels a degree
  double rows = 0.0;     ///< sum of the squares of the coefficients of y alone,
  double columns = 0.0;  ///< of x alone,
  double cross = 0.0;    ///< and of both, in the unit of the plane squared: sums over the pixels
  int cross_terms() const { return degree * (degree - 1) / 2; }
};

/// Subtracts it from the plane, whose mean stays.
Trend remove_trend(mtf::ImageView<float> plane, int degree);

}  // namespace calib
