// SPDX-License-Identifier: Apache-2.0
#pragma once

// The response that a joint fit found (reference, its change and the correction) as OTF and as edge spread function
// about the edge's location. Both are linear in the fit's unknowns, so that variances are quadratic forms of its
// covariance.
//
// The offset of the edge is one of the unknowns. Its derivative is the line spread, which the even splines span too, so
// that only the sum of both is known. The location of the edge is that about which the phase of this sum is least,
//   sum over f of 2 pi f |H| Im H(f) = 0,
// and changes of the response that are no more than a change of the location do not count as its noise.

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "calib/measure/correction/esf_correction.h"

namespace calib {

class EdgeResponse {
 public:
  EdgeResponse(const EdgeModel& model, const JointFit& joint);

  struct Otf {
    double re = 1.0, im = 0.0;
    double var_along = 0.0, var_across = 0.0;  ///< along the phase (the modulus) and at right angles to it
    double mtf() const;                        ///< |OTF| less the bias that noise across its phase adds
    double mtf_sd() const;
  };
  /// From where the joint fit's equations were taken to the location, towards the bright side.
  double shift_px() const { return shift_px_; }
  double shift_sd_px() const { return std::sqrt(std::max(0.0, shift_variance_)); }
  Otf otf(double f_cy_px) const;
  /// At 0, step .. (count - 1) step.
  std::vector<Otf> otfs(double step_cy_px, std::size_t count) const;
  double esf(double d_px) const;
  double lsf(double d_px) const;

  /// Derivatives by the unknowns that the response depends on.
  using Row = Eigen::VectorXd;
  struct Step {
    double esf = 0.0, lsf = 0.0;
    Row row;  ///< of E
  };
  Step step(double d_px) const;
  Row mtf_row(double f_cy_px) const;
  /// The changes of S, v and q from the solution to the upper end of the 95 % interval of the MTF at a frequency.
  std::array<double, kShapes> towards_sharper(double f_cy_px) const;
  Row esf_row(double d_px) const { return step(d_px).row; }
  Row lsf_row(double d_px) const;
  double variance(const Row& row) const { return covariance(row, row); }
  double covariance(const Row& a, const Row& b) const;

 private:
  // OTF, about where the equations were taken, and derivatives: by the first `real` unknowns of its real part, by the
  // others of its imaginary part.
  struct Parts {
    double re = 1.0, im = 0.0;
    Row slope;
    Eigen::Index real = 0;
    double modulus() const { return std::sqrt(re * re + im * im); }
    Row along() const;
  };
  // Splines of one kind, evenly spaced by their knots' distance.
  struct Run {
    StepChange first;
    Eigen::Index at = 0, count = 0;  // among the unknowns
  };
  Eigen::Index place_of(std::size_t change) const;  // among the unknowns
  void find_runs();
  // cos and sin of 2 pi f x, of each spline.
  struct Phases {
    Eigen::ArrayXd cos, sin;
  };
  Phases phases(double f_cy_px) const;
  Parts parts(double f_cy_px) const;
  /// Calls visit(f, parts) at 0, step .. (count - 1) step.
  template <class Visit>
  void walk(double step_cy_px, std::size_t count, const Visit& visit) const;
  void add_up(double f_cy_px, const ReferenceOtf& reference, const Phases& phases, Parts& parts) const;
  Otf otf_of(double f_cy_px, const Parts& at) const;
  void locate();
  Row change_row(double d_px) const;  // of E, about where the equations were taken
  Row slope_row(double d_px) const;
  double reference_esf(double d_px) const;
  double at_knots(const SideKnots& values, double d_px) const;

  ReferenceShape shape_;
  Point normal_;
  ReferenceTable table_;
  std::vector<std::size_t> shapes_;  // which of S, v, q are free
  std::vector<StepChange> changes_;  // of the real part, then of the imaginary one
  std::vector<Run> runs_;
  Eigen::Index real_ = 0;  // so many unknowns make the real part; the offset follows, then even splines
  Eigen::VectorXd value_;
  double shift_px_ = 0.0;
  Row shift_row_;         // derivatives of the location
  Row shift_covariance_;  // of it with each unknown
  double shift_variance_ = 0.0;
  Eigen::MatrixXd covariance_;
};

}  // namespace calib
