// SPDX-License-Identifier: Apache-2.0
#pragma once

// The last, joint least-squares solution for plateaus, geometry, shape and a correction of what the reference step does
// not describe: cubic B-splines, fine in the core of the edge spread function and coarse in its tails, in mirrored
// pairs,
//   odd  B((d - x)/h) - B((d + x)/h): a real part of the OTF,  4 pi f h sinc^4(f h) sin(2 pi f x),
//   even B((d - x)/h) + B((d + x)/h): an imaginary part,       4 pi f h sinc^4(f h) cos(2 pi f x).
// The coefficients of each of the two groups are Gaussian with variance tau^2 a(x)^2, where a falls with the distance;
// tau is found by maximum marginal likelihood (REML). Where the residuals are noise, tau is zero and nothing is added
// to the reference; the less noise there is the closer the correction follows the pixels. The covariance is that of the
// posterior, so that it includes what the correction may still miss.

#include <Eigen/Core>
#include <vector>

#include "calib/measure/edge_fit.h"

namespace calib {

struct SplinePair {
  double x_px = 0.0, h_px = 0.25;
  bool odd = true;
  double prior_sd = 1.0;  ///< a(x)
};
/// Half of the pair's value on the bright side: B((d - x)/h) -+ B((d + x)/h), d >= 0; and its slope.
double pair_value(const SplinePair& pair, double d_px);
double pair_slope(const SplinePair& pair, double d_px);

struct JointFit {
  std::vector<int> unknowns;        ///< of the model, in the order of `value`
  std::vector<SplinePair> splines;  ///< their coefficients follow in `value`
  Eigen::VectorXd value;            ///< changes of the unknowns, coefficients of the splines
  Eigen::MatrixXd covariance;
  double chi2_per_dof = 0.0;
  double tau_odd = 0.0, tau_even = 0.0;
  /// The residuals follow the real part of a correction, in the direction that they know best, by more than one
  /// standard deviation, whether or not that is enough to correct the reference.
  bool shape_in_doubt = false;
  double contrast_ratio = 1.0;  ///< old / new contrast: changes of E are in parts of the old one
};

/// How many splines: none where too few distances a pixel occur to tell a correction from aliases; fine ones, which
/// also extend further out, where the residuals exceed the noise.
enum class Detail { none, coarse, fine };

/// The likeliest tau, or the largest one that the pixels allow with 95 %.
enum class Smoothing { likeliest, least };

/// `width_px`: equivalent width of the line spread; `extent_px`: how far there are pixels on both sides.
JointFit solve_jointly(const FitState& state, const EdgeModel& model, const Unknowns& unknowns, Detail detail,
                       double width_px, double extent_px, Smoothing smoothing = Smoothing::likeliest);

}  // namespace calib
