// SPDX-License-Identifier: Apache-2.0
#pragma once

// The last, joint linear solution for plateaus, geometry, shape and what the reference step may lack: splines of the
// edge spread function, light that is scattered far, uneven light on the sides (step_changes.h, the plateau terms of
// residual_sums.h). Which of these parts there are and how large they are is averaged over (model_average.h): where the
// residuals are noise, nothing is added to the reference; where two parts explain them equally well, as a gradient of
// the light and a wide halo do in a narrow region, the covariance holds what differs between them. Uneven light is no
// part of the edge spread function, far light is.

#include <Eigen/Core>
#include <vector>

#include "calib/measure/correction/model_average.h"
#include "calib/measure/correction/step_changes.h"
#include "calib/measure/edge_fit.h"

namespace calib {

struct JointFit {
  std::vector<int> unknowns;        ///< of the model, in the order of `value`
  std::vector<StepChange> changes;  ///< their coefficients follow in `value`
  Eigen::VectorXd value;            ///< changes of the unknowns, coefficients of the step's changes
  Eigen::MatrixXd covariance;
  double chi2_per_dof = 0.0;
  std::array<double, kParts> probability{};  ///< of each part
  double contrast_ratio = 1.0;               ///< old / new contrast: changes of E are in parts of the old one
};

/// The state's equations are those of the model's `unknowns` and of all plateau terms.
JointFit solve_jointly(const FitState& state, const EdgeModel& model, const Unknowns& unknowns, Detail detail,
                       double width_px, double extent_px);

}  // namespace calib
