// SPDX-License-Identifier: Apache-2.0
#pragma once

// The covariance of the scores A^T W e of a weighted least-squares fit whose pixels have the noise e. That of
// independent pixels is the normal matrix A^T W A. Where neighbours share their noise it is A^T W R W A, with R the
// covariance of the pixels, sd sd' rho(their distance in rows and columns), and the covariance of the solution is the
// sandwich (A^T W A)^-1 A^T W R W A (A^T W A)^-1 (H. White, Econometrica 48, 817 (1980)). Derivatives are functions
// of the distance d from the edge, so that the pixel at a lag has the value of d + normal . lag, and R A is a sum over
// the lags of the rows, moved by that much.

#include <Eigen/Core>
#include <span>

#include "calib/measure/edge_fit.h"

namespace calib {

/// A derivative of the pixels: a function of d, by bin, times t^power.
struct ScoreColumn {
  BinRow row{};
  int power = 0;
};
/// That of an unknown of the model.
ScoreColumn score_column(const Basis& basis, const StepProfile& profile, int unknown);

/// A^T W R W A of the state's noise.
Eigen::MatrixXd score_covariance(const FitState& state, const EdgeModel& model, std::span<const ScoreColumn> columns);

/// Of the model's unknowns: the normal matrix where the pixels are independent.
Matrix score_covariance(const FitState& state, const EdgeModel& model, const Unknowns& unknowns);

/// A covariance of scores made no smaller than `least` in any direction: an estimated correlation can be trusted to say
/// that noise is more than that of independent pixels, but not that there is none.
Eigen::MatrixXd no_less_than(const Eigen::MatrixXd& least, const Eigen::MatrixXd& covariance);

}  // namespace calib
