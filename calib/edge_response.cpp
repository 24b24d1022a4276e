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
  Eigen::Index offset = 0;
  for (std::size_t i = 0; i < joint.unknowns.size(); ++i) {
    if (joint.unknowns[i] == kFirstShift) offset = static_cast<Eigen::Index>(i);
    if (joint.unknowns[i] < kFirstShape) continue;
    shapes_.push_back(static_cast<std::size_t>(joint.unknowns[i] - kFirstShape));
    from.push_back(static_cast<Eigen::Index>(i));
  }
  const auto add = [&](bool odd) {
    for (std::size_t j = 0; j < joint.splines.size(); ++j) {
      if (joint.splines[j].odd != odd) continue;
      splines_.push_back(joint.splines[j]);
      from.push_back(static_cast<Eigen::Index>(joint.unknowns.size() + j));
    }
  };
  add(true);
  real_ = static_cast<Eigen::Index>(from.size());
  from.push_back(offset);
  add(false);
  const auto size = static_cast<Eigen::Index>(from.size());
  value_.resize(size);
  covariance_.resize(size, size);
  for (Eigen::Index i = 0; i < size; ++i) {
    value_[i] = joint.contrast_ratio * joint.value[from[static_cast<std::size_t>(i)]];
    for (Eigen::Index j = 0; j < size; ++j)
      covariance_(i, j) = joint.covariance(from[static_cast<std::size_t>(i)], from[static_cast<std::size_t>(j)]);
  }
  locate();
}

EdgeResponse::Parts EdgeResponse::parts(double f_cy_px) const {
  Parts parts{.slope = Row(value_.size()), .real = real_};
  const ReferenceOtf reference = reference_otf(shape_, angle_rad_, f_cy_px);
  const auto shapes = static_cast<Eigen::Index>(shapes_.size());
  for (Eigen::Index i = 0; i < shapes; ++i) parts.slope[i] = reference.slope[shapes_[static_cast<std::size_t>(i)]];
  for (Eigen::Index i = shapes; i < real_; ++i)
    parts.slope[i] = pair_otf(splines_[static_cast<std::size_t>(i - shapes)], f_cy_px);
  parts.slope[real_] = -2.0 * kPi * f_cy_px * reference.value;
  for (Eigen::Index i = real_ + 1; i < value_.size(); ++i)
    parts.slope[i] = pair_otf(splines_[static_cast<std::size_t>(i - 1 - shapes)], f_cy_px);
  const Eigen::Index rest = value_.size() - real_;
  parts.re = reference.value + parts.slope.head(real_).dot(value_.head(real_));
  parts.im = parts.slope.tail(rest).dot(value_.tail(rest));
  return parts;
}

EdgeResponse::Row EdgeResponse::Parts::along() const {
  const double most = modulus();
  Row row = slope;
  row.head(real) *= most > 0.0 ? re / most : 1.0;
  row.tail(slope.size() - real) *= most > 0.0 ? im / most : 0.0;
  return row;
}

EdgeResponse::Row EdgeResponse::Parts::across() const {
  const double most = modulus();
  Row row = slope;
  row.head(real) *= most > 0.0 ? -im / most : 0.0;
  row.tail(slope.size() - real) *= most > 0.0 ? re / most : 1.0;
  return row;
}

double EdgeResponse::covariance(const Row& a, const Row& b) const {
  double sum = 0.0;
  for (Eigen::Index i = 0; i < a.size(); ++i) sum += a[i] * covariance_.col(i).dot(b);
  return sum;
}

// Newton's method for the least phase.
void EdgeResponse::locate() {
  constexpr int kFrequencies = 64, kRounds = 8;
  constexpr double kTop_cy_px = 0.8;
  std::vector<Parts> all;
  double weight = 0.0;
  shift_row_ = Row::Zero(value_.size());
  for (int i = 1; i <= kFrequencies; ++i) {
    all.push_back(parts(kTop_cy_px * i / kFrequencies));
    const double turn = 2.0 * kPi * kTop_cy_px * i / kFrequencies * all.back().modulus();
    weight += turn * turn;
    shift_row_ -= turn * all.back().across();
  }
  if (!(weight > 0.0)) return;
  shift_row_ /= weight;
  for (int round = 0; round < kRounds; ++round) {
    double sum = 0.0;
    for (int i = 1; i <= kFrequencies; ++i) {
      const Parts& at = all[static_cast<std::size_t>(i - 1)];
      const double turn = 2.0 * kPi * kTop_cy_px * i / kFrequencies;
      sum += turn * at.modulus() * (at.im * std::cos(turn * shift_px_) + at.re * std::sin(turn * shift_px_));
    }
    shift_px_ -= sum / weight;
  }
  if (!(std::abs(shift_px_) < kReach_px)) shift_px_ = 0.0;
}

EdgeResponse::Otf EdgeResponse::otf(double f_cy_px) const {
  const Parts at = parts(f_cy_px);
  const double turn = 2.0 * kPi * f_cy_px, c = std::cos(turn * shift_px_), s = std::sin(turn * shift_px_);
  const Row across = at.across() + turn * at.modulus() * shift_row_;
  return {.re = at.re * c - at.im * s,
          .im = at.im * c + at.re * s,
          .var_along = std::max(0.0, variance(at.along())),
          .var_across = std::max(0.0, variance(across))};
}

double EdgeResponse::Otf::mtf() const { return std::sqrt(std::max(0.0, re * re + im * im - var_across)); }

double EdgeResponse::Otf::mtf_sd() const {
  const double square = re * re + im * im;
  // Where the modulus is within its noise, its direction is not known, and either part may be the one along it.
  return std::sqrt(square > var_across ? var_along : std::max(var_along, var_across));
}

EdgeResponse::Row EdgeResponse::mtf_row(double f_cy_px) const { return parts(f_cy_px).along(); }

double EdgeResponse::at_knots(const std::array<double, kSideBins + 1>& values, double d_px) const {
  const DistanceBins& bins = DistanceBins::get();
  const double d = std::min(std::abs(d_px), kReach_px * (1.0 - 1e-12));
  const int i = bins.index(d);
  const auto side = static_cast<std::size_t>(i - kSideBins);
  const double t = (d - bins.knot(i)) / bins.width(i);
  return values[side] + t * (values[side + 1] - values[side]);
}

EdgeResponse::Row EdgeResponse::change_row(double d_px) const {
  Row row(value_.size());
  const double sign = d_px < 0.0 ? -1.0 : 1.0;
  const auto shapes = static_cast<Eigen::Index>(shapes_.size());
  for (Eigen::Index i = 0; i < shapes; ++i)
    row[i] = sign * at_knots(table_.slope[shapes_[static_cast<std::size_t>(i)]], d_px);
  for (Eigen::Index i = shapes; i < real_; ++i)
    row[i] = sign * pair_value(splines_[static_cast<std::size_t>(i - shapes)], std::abs(d_px));
  row[real_] = -at_knots(table_.lsf, d_px);
  for (Eigen::Index i = real_ + 1; i < row.size(); ++i)
    row[i] = pair_value(splines_[static_cast<std::size_t>(i - 1 - shapes)], std::abs(d_px));
  return row;
}

EdgeResponse::Row EdgeResponse::slope_row(double d_px) const {
  constexpr double kStep_px = 1.0 / kFinest;
  const double above = d_px + kStep_px, below = d_px - kStep_px;
  const auto slope_of = [&](const std::array<double, kSideBins + 1>& values, bool odd) {
    const double a = at_knots(values, above), b = at_knots(values, below);
    return ((odd && above < 0.0 ? -a : a) - (odd && below < 0.0 ? -b : b)) / (2.0 * kStep_px);
  };
  Row row(value_.size());
  const double sign = d_px < 0.0 ? -1.0 : 1.0;
  const auto shapes = static_cast<Eigen::Index>(shapes_.size());
  for (Eigen::Index i = 0; i < shapes; ++i) row[i] = slope_of(table_.slope[shapes_[static_cast<std::size_t>(i)]], true);
  for (Eigen::Index i = shapes; i < real_; ++i)
    row[i] = pair_slope(splines_[static_cast<std::size_t>(i - shapes)], std::abs(d_px));
  row[real_] = -slope_of(table_.lsf, false);
  for (Eigen::Index i = real_ + 1; i < row.size(); ++i)
    row[i] = sign * pair_slope(splines_[static_cast<std::size_t>(i - 1 - shapes)], std::abs(d_px));
  return row;
}

EdgeResponse::Step EdgeResponse::step(double d_px) const {
  const double at = d_px + shift_px_;
  Step step{.row = change_row(at)};
  step.esf = reference_esf(at) + step.row.dot(value_);
  step.lsf = lsf(d_px);
  step.row += step.lsf * shift_row_;
  return step;
}

EdgeResponse::Row EdgeResponse::lsf_row(double d_px) const {
  constexpr double kStep_px = 1.0 / kFinest;
  const double bend = (lsf(d_px + kStep_px) - lsf(d_px - kStep_px)) / (2.0 * kStep_px);
  return slope_row(d_px + shift_px_) + bend * shift_row_;
}

double EdgeResponse::reference_esf(double d_px) const {
  const DistanceBins& bins = DistanceBins::get();
  const double d = std::min(std::abs(d_px), kReach_px * (1.0 - 1e-12));
  const int i = bins.index(d);
  const auto side = static_cast<std::size_t>(i - kSideBins);
  const double h = bins.width(i), t = (d - bins.knot(i)) / h, u = 1.0 - t;
  const double odd = u * u * ((1.0 + 2.0 * t) * table_.odd[side] + t * h * table_.lsf[side]) +
                     t * t * ((1.0 + 2.0 * u) * table_.odd[side + 1] - u * h * table_.lsf[side + 1]);
  return 0.5 + std::copysign(odd, d_px);
}

double EdgeResponse::esf(double d_px) const {
  const double at = d_px + shift_px_;
  return reference_esf(at) + change_row(at).dot(value_);
}

double EdgeResponse::lsf(double d_px) const {
  const double at = d_px + shift_px_;
  return at_knots(table_.lsf, at) + slope_row(at).dot(value_);
}

}  // namespace calib
