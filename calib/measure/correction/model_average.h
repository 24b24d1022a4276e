// SPDX-License-Identifier: Apache-2.0
#pragma once

// A linear model whose parts may be absent or of any size. The unknowns of a part are Gaussian about zero with the
// standard deviation (size x unit); a hypothesis says the size of each part, 0 = absent. What follows from the data is
// the average over the hypotheses, each with its prior probability times its evidence, the probability of the data
// (J. A. Hoeting et al., Statistical Science 14, 382 (1999)); those below a twentieth of the likeliest are left out,
// so that a part which nothing speaks for changes no digit (Occam's window, D. Madigan and A. E. Raftery, J. Am. Stat.
// Assoc. 89, 1535 (1994)). With I the information on the parts' unknowns, what the others explain taken out, u their
// scores and P the prior variances, the evidence is
//   exp(u^T (I + P^-1)^-1 u / 2) / sqrt(det(1 + P I)).

#include <Eigen/Core>
#include <array>
#include <vector>

namespace calib {

/// The parts that the model of an edge may have besides plateaus, geometry, a Gaussian and a footprint.
enum Part : int {
  kDiffraction,  ///< S
  kGradient,     ///< of the light on a side, linear
  kCurvature,    ///< the same, square
  kFarLight,     ///< wide steps
  kNearLight,    ///< steps a few pixels wide, as sharpening subtracts
  kReal,         ///< odd splines
  kImaginary,    ///< even splines
  kParts
};
using PartSizes = std::array<double, kParts>;

struct LinearModel {
  Eigen::MatrixXd information;
  Eigen::VectorXd score;
  Eigen::Index fixed = 0;   ///< the first unknowns, which are no part's
  std::vector<Part> part;   ///< of each further unknown
  Eigen::VectorXd unit_sd;  ///< of each further unknown
  double share = 1.0;       ///< of the information, that far light and shading are judged by
  bool wide = false;        ///< a blur wider than pixel and diffraction make it: its shape is that of anything
};

struct ModelAverage {
  Eigen::VectorXd mean;
  Eigen::MatrixXd covariance;
  std::array<double, kParts> probability{};  ///< of each part
};
ModelAverage average_over_parts(const LinearModel& model);

}  // namespace calib
