// SPDX-License-Identifier: Apache-2.0
#pragma once

// Tests whether residuals are noise. For an edge, their means over fine bins of the distance d are compared with the
// scatter inside the bins (the ratio does not depend on the size of the noise), and neighbouring means with each other;
// a wrong E shows in both. Rounded images without noise have means off by up to half a step at any d: their share is
// added to the variance of a mean, and so is what tables and quadratures leave, 1e-6 of the contrast.

#include <span>
#include <vector>

#include "calib/edge/pixel_correlation.h"
#include "calib/fit/data/data_block.h"

namespace calib {

struct ResidualBin {
  double distance_px = 0.0;  ///< mean distance of its pixels
  double width_px = 0.0;
  double mean = 0.0;      ///< mean residual, in sd of the noise
  double variance = 0.0;  ///< variance of the mean, were the residuals noise
};

struct Adequacy {
  double chi2 = 0.0;           ///< sum of squares, outliers bent (data_block.h)
  double outlier_share = 0.0;  ///< share of residuals beyond 4 sd
  double whiteness_p = 1.0;    ///< probability of residuals at least as structured, were they noise
  double structure = 0.0;      ///< rms of the means beyond their noise, in sd of the noise
  std::vector<ResidualBin> bins;
};

/// `fitted`: number of unknowns that change E or the plateaus; `contrast` and `quantum` in the image's unit, 0 for what
/// has none.
Adequacy judge_edge(std::span<const Residual> residuals, std::size_t fitted, double contrast, double quantum);

/// Residuals of an edge that are far enough from each other to be independent where neighbouring pixels share their
/// noise, as after demosaicing, denoising or JPEG.
struct IndependentResiduals {
  std::vector<Residual> residuals;
  int spacing_px = 1;        ///< every so-many-th column and row; 1 = all, the noise is not correlated
  NoiseCorrelation noise{};  ///< of all pixels
};
/// The correlation is estimated from pixels at least `flat_px` from the edge, whose normal is given.
IndependentResiduals independent(std::vector<Residual> residuals, Point normal, double flat_px);

/// For curves and spots: neighbours in the order given.
Adequacy judge_sequence(std::span<const Residual> residuals);

/// |OTF| of the edge's residual step, shrunk by its variance; zero where the residuals are noise. In units of the
/// contrast, given the contrast in sd of the noise.
std::vector<double> residual_otf(const Adequacy& adequacy, double contrast_sd, std::span<const double> f_cy_px);

/// Probability that the ratio of two mean squares of noise is at least as large.
double f_tail(double ratio, double dof1, double dof2);

}  // namespace calib
