// SPDX-License-Identifier: Apache-2.0
#include "calib/edge_response.h"

#include <algorithm>
#include <cmath>

#include "mtf/special.h"

namespace calib {
namespace {

constexpr double kPi = mtf::kPi;

// Of a pair of splines, real or imaginary as the pair is odd or even.
double pair_otf(const SplinePair& pair, double f_cy_px) {
  const double sinc = mtf::sinc(f_cy_px * pair.h_px).value, window = sinc * sinc * sinc * sinc;
  const double half = 2.0 * kPi * f_cy_px * pair.h_px * window;
  if (pair.x_px == 0.0) return half;
  const mtf::SinCos phase = mtf::sin_cos_pi(2.0 * f_cy_px * pair.x_px);
  return 2.0 * half * (pair.odd ? phase.sin : phase.cos);
}

}  // namespace

EdgeResponse::EdgeResponse(const EdgeModel& model, const JointFit& joint)
    : shape_(model.shape), angle_rad_(model.curve.angle_rad), table_(tabulate(model.shape, model.curve.angle_rad)) {
  std::vector<Eigen::Index> from;
  for (std::size_t i = 0; i < joint.unknowns.size(); ++i) {
    if (joint.unknowns[i] < kFirstShape) continue;
    shapes_.push_back(static_cast<std::size_t>(joint.unknowns[i] - kFirstShape));
    from.push_back(static_cast<Eigen::Index>(i));
  }
  real_ = static_cast<Eigen::Index>(from.size());
  for (std::size_t j = 0; j < joint.splines.size(); ++j) {  // odd ones come first
    splines_.push_back(joint.splines[j]);
    if (joint.splines[j].odd) ++real_;
    from.push_back(static_cast<Eigen::Index>(joint.unknowns.size() + j));
  }
  const auto size = static_cast<Eigen::Index>(from.size());
  value_.resize(size);
  covariance_.resize(size, size);
  for (Eigen::Index i = 0; i < size; ++i) {
    value_[i] = joint.value[from[static_cast<std::size_t>(i)]];
    for (Eigen::Index j = 0; j < size; ++j)
      covariance_(i, j) = joint.covariance(from[static_cast<std::size_t>(i)], from[static_cast<std::size_t>(j)]);
  }
}

void EdgeResponse::fill_real(double f_cy_px, const ReferenceOtf& reference, Row& row) const {
  const auto shapes = static_cast<Eigen::Index>(shapes_.size());
  for (Eigen::Index i = 0; i < shapes; ++i) row[i] = reference.slope[shapes_[static_cast<std::size_t>(i)]];
  for (Eigen::Index i = shapes; i < real_; ++i)
    row[i] = pair_otf(splines_[static_cast<std::size_t>(i - shapes)], f_cy_px);
}

void EdgeResponse::fill_imaginary(double f_cy_px, Row& row) const {
  const auto shapes = static_cast<Eigen::Index>(shapes_.size());
  for (Eigen::Index i = real_; i < row.size(); ++i)
    row[i] = pair_otf(splines_[static_cast<std::size_t>(i - shapes)], f_cy_px);
}

EdgeResponse::Otf EdgeResponse::otf(double f_cy_px) const {
  Row row = Row::Zero(value_.size());
  const ReferenceOtf reference = reference_otf(shape_, angle_rad_, f_cy_px);
  fill_real(f_cy_px, reference, row);
  fill_imaginary(f_cy_px, row);
  const Eigen::Index rest = value_.size() - real_;
  Otf otf{.re = reference.value + row.head(real_).dot(value_.head(real_)), .im = row.tail(rest).dot(value_.tail(rest))};
  otf.var_re = row.head(real_).dot(covariance_.topLeftCorner(real_, real_) * row.head(real_));
  otf.var_im = row.tail(rest).dot(covariance_.bottomRightCorner(rest, rest) * row.tail(rest));
  return otf;
}

double EdgeResponse::Otf::mtf() const {
  const double square = re * re + im * im;
  const double across = square > 0.0 ? (im * im * var_re + re * re * var_im) / square : 0.0;
  return std::sqrt(std::max(0.0, square - across));
}

double EdgeResponse::Otf::mtf_sd() const {
  const double square = re * re + im * im;
  return std::sqrt(std::max(0.0, square > 0.0 ? (re * re * var_re + im * im * var_im) / square : var_re));
}

EdgeResponse::Row EdgeResponse::mtf_row(double f_cy_px) const {
  Row row = Row::Zero(value_.size());
  fill_real(f_cy_px, reference_otf(shape_, angle_rad_, f_cy_px), row);
  fill_imaginary(f_cy_px, row);
  const Otf at = otf(f_cy_px);
  const double modulus = std::hypot(at.re, at.im);
  if (modulus == 0.0) return row;
  row.head(real_) *= at.re / modulus;
  row.tail(row.size() - real_) *= at.im / modulus;
  return row;
}

double EdgeResponse::at_knots(const std::array<double, kSideBins + 1>& values, double d_px) const {
  const DistanceBins& bins = DistanceBins::get();
  const double d = std::min(std::abs(d_px), kReach_px * (1.0 - 1e-12));
  const int i = bins.index(d);
  const auto side = static_cast<std::size_t>(i - kSideBins);
  const double t = (d - bins.knot(i)) / (bins.knot(i + 1) - bins.knot(i));
  return values[side] + t * (values[side + 1] - values[side]);
}

EdgeResponse::Row EdgeResponse::esf_row(double d_px) const {
  Row row(value_.size());
  const double sign = d_px < 0.0 ? -1.0 : 1.0;
  const auto shapes = static_cast<Eigen::Index>(shapes_.size());
  for (Eigen::Index i = 0; i < shapes; ++i)
    row[i] = sign * at_knots(table_.slope[shapes_[static_cast<std::size_t>(i)]], d_px);
  for (Eigen::Index i = shapes; i < row.size(); ++i)
    row[i] = (i < real_ ? sign : 1.0) * pair_value(splines_[static_cast<std::size_t>(i - shapes)], std::abs(d_px));
  return row;
}

EdgeResponse::Row EdgeResponse::lsf_row(double d_px) const {
  constexpr double kStep_px = 1.0 / kFinest;
  Row row = (esf_row(d_px + kStep_px) - esf_row(d_px - kStep_px)) / (2.0 * kStep_px);
  const double sign = d_px < 0.0 ? -1.0 : 1.0;
  const auto shapes = static_cast<Eigen::Index>(shapes_.size());
  for (Eigen::Index i = shapes; i < row.size(); ++i)
    row[i] = (i < real_ ? 1.0 : sign) * pair_slope(splines_[static_cast<std::size_t>(i - shapes)], std::abs(d_px));
  return row;
}

double EdgeResponse::esf(double d_px) const {
  const DistanceBins& bins = DistanceBins::get();
  const double d = std::min(std::abs(d_px), kReach_px * (1.0 - 1e-12));
  const int i = bins.index(d);
  const auto side = static_cast<std::size_t>(i - kSideBins);
  const double h = bins.knot(i + 1) - bins.knot(i), t = (d - bins.knot(i)) / h, u = 1.0 - t;
  const double odd = u * u * ((1.0 + 2.0 * t) * table_.odd[side] + t * h * table_.lsf[side]) +
                     t * t * ((1.0 + 2.0 * u) * table_.odd[side + 1] - u * h * table_.lsf[side + 1]);
  return 0.5 + std::copysign(odd, d_px) + esf_row(d_px).dot(value_);
}

double EdgeResponse::lsf(double d_px) const { return at_knots(table_.lsf, d_px) + lsf_row(d_px).dot(value_); }

}  // namespace calib
