// SPDX-License-Identifier: Apache-2.0
#pragma once

// The response that a joint fit found, reference + its change + correction, as OTF and as edge spread function about
// the edge's location. Everything is linear in the fit's unknowns, so variances are quadratic forms of its covariance.

#include <Eigen/Core>
#include <vector>

#include "calib/esf_correction.h"

namespace calib {

class EdgeResponse {
 public:
  EdgeResponse(const EdgeModel& model, const JointFit& joint);

  struct Otf {
    double re = 1.0, im = 0.0;
    double var_re = 0.0, var_im = 0.0;
    double mtf() const;  ///< |OTF| less what the noise across its phase adds on average
    double mtf_sd() const;
  };
  Otf otf(double f_cy_px) const;
  double esf(double d_px) const;
  double lsf(double d_px) const;

  /// Derivatives by the unknowns that the response depends on.
  using Row = Eigen::VectorXd;
  Row mtf_row(double f_cy_px) const;
  Row esf_row(double d_px) const;
  Row lsf_row(double d_px) const;
  double variance(const Row& row) const { return covariance(row, row); }
  double covariance(const Row& a, const Row& b) const { return a.dot(covariance_ * b); }

 private:
  void fill_real(double f_cy_px, const ReferenceOtf& reference, Row& row) const;
  void fill_imaginary(double f_cy_px, Row& row) const;
  double at_knots(const std::array<double, kSideBins + 1>& values, double d_px) const;

  ReferenceShape shape_;
  double angle_rad_ = 0.0;
  ReferenceTable table_;
  std::vector<std::size_t> shapes_;  // which of S, v, q are free
  std::vector<SplinePair> splines_;
  Eigen::Index real_ = 0;  // the first so many unknowns make the real part
  Eigen::VectorXd value_;
  Eigen::MatrixXd covariance_;
};

}  // namespace calib
