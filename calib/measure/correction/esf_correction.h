// SPDX-License-Identifier: Apache-2.0
#pragma once

// The last, joint linear solution for plateaus, geometry, shape and what the reference step may lack: splines of the
// edge spread function, light that is scattered far, uneven light on the sides (StepChange, the plateau terms of
// residual_sums.h). Which of these parts there are and how large they are is averaged over (model_average.h): where the
// residuals are noise, nothing is added to the reference; where two parts explain them equally well, as a gradient of
// the light and a wide halo do in a narrow region, the covariance holds what differs between them. Uneven light is no
// part of the edge spread function, far light is.

#include <Eigen/Core>
#include <vector>

#include "calib/measure/correction/model_average.h"
#include "calib/measure/edge_fit.h"

namespace calib {

// What the reference step may lack, as changes of the edge spread function whose transforms are closed forms:
// cubic B-splines, fine in the core and coarse in the tails, in mirrored pairs,
//   odd  B((d - x)/h) - B((d + x)/h): a real part of the OTF,  4 pi f h sinc^4(f h) sin(2 pi f x),
//   even B((d - x)/h) + B((d + x)/h): an imaginary part,       4 pi f h sinc^4(f h) cos(2 pi f x),
// and light that is scattered far: a wide step takes the place of a part of a narrow one, Phi(d / x),
//   Lorentzian 1/2 + atan(d / h) / pi - Phi(d / x),  exp(-2 pi h f) - exp(-2 pi^2 x^2 f^2),
//   Gaussian   Phi(d / h) - Phi(d / x),              exp(-2 pi^2 h^2 f^2) - exp(-2 pi^2 x^2 f^2).

/// Widths of wide steps from which light counts as scattered far.
inline constexpr double kFar_px = 5.0;

struct StepChange {
  enum class Kind { odd, even, lorentzian, gaussian };
  Kind kind = Kind::odd;
  double x_px = 0.0;      ///< place of a spline; standard deviation of the narrow step
  double h_px = 0.25;     ///< distance of the knots; half width or standard deviation of the wide step
  double prior_sd = 1.0;  ///< relative to those of its kind
  bool wide() const { return kind == Kind::lorentzian || kind == Kind::gaussian; }
};
double change_value(const StepChange& change, double d_px);
double change_slope(const StepChange& change, double d_px);
/// The transform of a change by a wide step.
double wide_otf(const StepChange& change, double f_cy_px);

/// How many splines: none where too few distances a pixel occur to tell a correction from aliases; fine ones, which
/// also extend further out, where the residuals exceed the noise.
enum class Detail { none, coarse, fine };

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
