// SPDX-License-Identifier: Apache-2.0
#include "calib/measure/correction/edge_response.h"

#include "mtf/math/special.h"

namespace calib {
namespace {

using mtf::kPi;

struct BetweenKnots {
  std::size_t side;  // number of the knot before, of the bright side
  double width, t;   // of the bin; 0 .. 1 in it
};
BetweenKnots between_knots(double d_px) {
  const DistanceBins& bins = DistanceBins::get();
  const double d = std::min(std::abs(d_px), kRange_px * (1.0 - 1e-12));
  const int i = bins.index(d);
  return {static_cast<std::size_t>(i - kSideBins), bins.width(i), (d - bins.knot(i)) / bins.width(i)};
}

}  // namespace

EdgeResponse::EdgeResponse(const EdgeModel& model, const JointFit& joint)
    : shape_(model.shape), normal_(model.curve.normal()), table_(tabulate(model.shape, model.curve.angle_rad)) {
  std::vector<Eigen::Index> from;
  Eigen::Index offset = 0;
  for (std::size_t i = 0; i < joint.unknowns.size(); ++i) {
    if (joint.unknowns[i] == kFirstShift) offset = static_cast<Eigen::Index>(i);
    if (joint.unknowns[i] < kFirstShape) continue;
    shapes_.push_back(static_cast<std::size_t>(joint.unknowns[i] - kFirstShape));
    from.push_back(static_cast<Eigen::Index>(i));
  }
  const auto add = [&](bool real) {
    for (std::size_t j = 0; j < joint.changes.size(); ++j) {
      if ((joint.changes[j].kind != StepChange::Kind::even) != real) continue;
      changes_.push_back(joint.changes[j]);
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
  find_runs();
  locate();
  shift_covariance_ = covariance_ * shift_row_;
  shift_variance_ = shift_covariance_.dot(shift_row_);
}

Eigen::Index EdgeResponse::place_of(std::size_t change) const {
  const auto at = static_cast<Eigen::Index>(shapes_.size() + change);
  return at < real_ ? at : at + 1;
}

void EdgeResponse::find_runs() {
  for (std::size_t j = 0; j < changes_.size(); ++j) {
    const StepChange& pair = changes_[j];
    if (pair.wide()) continue;
    const Eigen::Index at = place_of(j);
    if (!runs_.empty()) {
      Run& run = runs_.back();
      const double next = run.first.x_px + static_cast<double>(run.count) * run.first.h_px;
      if (run.first.kind == pair.kind && run.first.h_px == pair.h_px && std::abs(next - pair.x_px) < 1e-9 &&
          run.at + run.count == at) {
        ++run.count;
        continue;
      }
    }
    runs_.push_back({.first = pair, .at = at, .count = 1});
  }
}

// From one pair of a run to the next the phase turns by the same angle.
EdgeResponse::Phases EdgeResponse::phases(double f_cy_px) const {
  Phases phases{Eigen::ArrayXd::Ones(value_.size()), Eigen::ArrayXd::Zero(value_.size())};
  for (const Run& run : runs_) {
    mtf::SinCos phase = mtf::sin_cos_pi(2.0 * f_cy_px * run.first.x_px);
    const mtf::SinCos turn = mtf::sin_cos_pi(2.0 * f_cy_px * run.first.h_px);
    for (Eigen::Index i = run.at; i < run.at + run.count; ++i) {
      phases.cos[i] = phase.cos;
      phases.sin[i] = phase.sin;
      phase = {phase.sin * turn.cos + phase.cos * turn.sin, phase.cos * turn.cos - phase.sin * turn.sin};
    }
  }
  return phases;
}

// Real or imaginary as the pairs are odd or even.
void EdgeResponse::add_up(double f_cy_px, const ReferenceOtf& reference, const Phases& phases, Parts& parts) const {
  const Eigen::Index rest = value_.size() - real_;
  parts.slope.head(real_) = phases.sin.head(real_);
  parts.slope.tail(rest) = phases.cos.tail(rest);
  for (const Run& run : runs_) {
    const double sinc = mtf::sinc(f_cy_px * run.first.h_px).value, window = sinc * sinc * sinc * sinc;
    parts.slope.segment(run.at, run.count) *= 4.0 * kPi * f_cy_px * run.first.h_px * window;
    if (run.first.x_px == 0.0) parts.slope[run.at] *= 0.5;
  }
  const auto shapes = static_cast<Eigen::Index>(shapes_.size());
  for (Eigen::Index i = 0; i < shapes; ++i) parts.slope[i] = reference.slope[shapes_[static_cast<std::size_t>(i)]];
  for (std::size_t j = 0; j < changes_.size(); ++j)
    if (changes_[j].wide()) parts.slope[place_of(j)] = wide_otf(changes_[j], f_cy_px);
  parts.slope[real_] = -2.0 * kPi * f_cy_px * reference.value;
  parts.re = reference.value + parts.slope.head(real_).dot(value_.head(real_));
  parts.im = parts.slope.tail(rest).dot(value_.tail(rest));
}

EdgeResponse::Parts EdgeResponse::parts(double f_cy_px) const {
  Parts parts{.slope = Row(value_.size()), .real = real_};
  add_up(f_cy_px, reference_otf(shape_, normal_, f_cy_px), phases(f_cy_px), parts);
  return parts;
}

// From one frequency to the next every phase turns by its own angle.
template <class Visit>
void EdgeResponse::walk(double step_cy_px, std::size_t count, const Visit& visit) const {
  std::vector<double> f_cy_px(count);
  for (std::size_t i = 0; i < count; ++i) f_cy_px[i] = static_cast<double>(i) * step_cy_px;
  const std::vector<ReferenceOtf> references = reference_otfs(shape_, normal_, f_cy_px);
  Phases now = phases(0.0);
  const Phases turn = phases(step_cy_px);
  Eigen::ArrayXd next(value_.size());
  Parts parts{.slope = Row(value_.size()), .real = real_};
  for (std::size_t i = 0; i < count; ++i) {
    add_up(f_cy_px[i], references[i], now, parts);
    visit(f_cy_px[i], parts);
    next = now.cos * turn.cos - now.sin * turn.sin;
    now.sin = now.sin * turn.cos + now.cos * turn.sin;
    now.cos.swap(next);
  }
}

EdgeResponse::Row EdgeResponse::Parts::along() const {
  const double most = modulus();
  Row row = slope;
  row.head(real) *= most > 0.0 ? re / most : 1.0;
  row.tail(slope.size() - real) *= most > 0.0 ? im / most : 0.0;
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
  constexpr double kTop_cy_px = 0.8, kExact_px = 1e-10;
  struct Value {
    double turn, re, im, modulus;
  };
  std::array<Value, kFrequencies> all;
  double weight = 0.0;
  shift_row_ = Row::Zero(value_.size());
  std::size_t count = 0;
  walk(kTop_cy_px / kFrequencies, kFrequencies + 1, [&](double f_cy_px, const Parts& at) {
    if (f_cy_px == 0.0) return;
    const Value& one = all[count++] = {2.0 * kPi * f_cy_px, at.re, at.im, at.modulus()};
    const double turn = one.turn * one.modulus, per_modulus = one.modulus > 0.0 ? 1.0 / one.modulus : 0.0;
    weight += turn * turn;
    const Eigen::Index rest = value_.size() - real_;
    shift_row_.head(real_) += turn * one.im * per_modulus * at.slope.head(real_);
    shift_row_.tail(rest) -= turn * (one.modulus > 0.0 ? one.re * per_modulus : 1.0) * at.slope.tail(rest);
  });
  if (!(weight > 0.0)) return;
  shift_row_ /= weight;
  for (int round = 0; round < kRounds; ++round) {
    const double angle = all[0].turn * shift_px_, c1 = std::cos(angle), s1 = std::sin(angle);
    double sum = 0.0, c = 1.0, s = 0.0;
    for (const Value& at : all) {
      const double next = c * c1 - s * s1;
      s = s * c1 + c * s1;
      c = next;
      sum += at.turn * at.modulus * (at.im * c + at.re * s);
    }
    shift_px_ -= sum / weight;
    if (std::abs(sum) <= kExact_px * weight) break;
  }
  if (!(std::abs(shift_px_) < kRange_px)) shift_px_ = 0.0;
}

EdgeResponse::Otf EdgeResponse::otf(double f_cy_px) const { return otf_of(f_cy_px, parts(f_cy_px)); }

std::vector<EdgeResponse::Otf> EdgeResponse::otfs(double step_cy_px, std::size_t count) const {
  std::vector<Otf> list;
  list.reserve(count);
  walk(step_cy_px, count, [&](double f_cy_px, const Parts& at) { list.push_back(otf_of(f_cy_px, at)); });
  return list;
}

EdgeResponse::Otf EdgeResponse::otf_of(double f_cy_px, const Parts& at) const {
  const double turn = 2.0 * kPi * f_cy_px, c = std::cos(turn * shift_px_), s = std::sin(turn * shift_px_);
  // Variances of the real and the imaginary part, and from them those along the modulus and across.
  const Eigen::Index n = value_.size(), rest = n - real_;
  double real = 0.0, both = 0.0, imaginary = 0.0;
  const auto products = [&](Eigen::Index i, Eigen::Index from, Eigen::Index end) {
    return covariance_.col(i).segment(from, end - from).dot(at.slope.segment(from, end - from));
  };
  for (Eigen::Index i = 0; i < real_; ++i) {
    const double mine = at.slope[i];
    real += mine * (mine * covariance_(i, i) + 2.0 * products(i, i + 1, real_));
    both += mine * products(i, real_, n);
  }
  for (Eigen::Index i = real_; i < n; ++i) {
    const double mine = at.slope[i];
    imaginary += mine * (mine * covariance_(i, i) + 2.0 * products(i, i + 1, n));
  }
  const double modulus = at.modulus(), a = modulus > 0.0 ? at.re / modulus : 1.0,
               b = modulus > 0.0 ? at.im / modulus : 0.0, k = turn * modulus;
  const double shift = a * at.slope.tail(rest).dot(shift_covariance_.tail(rest)) -
                       b * at.slope.head(real_).dot(shift_covariance_.head(real_));
  const double along = a * a * real + 2.0 * a * b * both + b * b * imaginary;
  const double across = b * b * real - 2.0 * a * b * both + a * a * imaginary + k * (2.0 * shift + k * shift_variance_);
  return {.re = at.re * c - at.im * s,
          .im = at.im * c + at.re * s,
          .var_along = std::max(0.0, along),
          .var_across = std::max(0.0, across)};
}

double EdgeResponse::Otf::mtf() const { return std::sqrt(std::max(0.0, re * re + im * im - var_across)); }

double EdgeResponse::Otf::mtf_sd() const {
  const double square = re * re + im * im;
  // Where the modulus is within its noise, its phase is unknown, so that either part may be the one along it.
  return std::sqrt(square > var_across ? var_along : std::max(var_along, var_across));
}

EdgeResponse::Row EdgeResponse::mtf_row(double f_cy_px) const { return parts(f_cy_px).along(); }

std::array<double, kShapes> EdgeResponse::towards_sharper(double f_cy_px) const {
  constexpr double k95_sd = 1.96;
  const Row row = mtf_row(f_cy_px), direction = covariance_ * row;
  const double variance = direction.dot(row), times = variance > 0.0 ? k95_sd / std::sqrt(variance) : 0.0;
  std::array<double, kShapes> change{};
  for (std::size_t i = 0; i < shapes_.size(); ++i) change[shapes_[i]] = times * direction[static_cast<Eigen::Index>(i)];
  return change;
}

double EdgeResponse::at_knots(const SideKnots& values, double d_px) const {
  const auto [side, width, t] = between_knots(d_px);
  return values[side] + t * (values[side + 1] - values[side]);
}

EdgeResponse::Row EdgeResponse::change_row(double d_px) const {
  Row row(value_.size());
  const double sign = d_px < 0.0 ? -1.0 : 1.0;
  for (std::size_t i = 0; i < shapes_.size(); ++i)
    row[static_cast<Eigen::Index>(i)] = sign * at_knots(table_.slope[shapes_[i]], d_px);
  row[real_] = -at_knots(table_.lsf, d_px);
  for (std::size_t j = 0; j < changes_.size(); ++j) row[place_of(j)] = change_value(changes_[j], d_px);
  return row;
}

EdgeResponse::Row EdgeResponse::slope_row(double d_px) const {
  constexpr double kStep_px = 1.0 / kFinest;
  const double above = d_px + kStep_px, below = d_px - kStep_px;
  const auto slope_of = [&](const SideKnots& values, bool odd) {
    const double a = at_knots(values, above), b = at_knots(values, below);
    return ((odd && above < 0.0 ? -a : a) - (odd && below < 0.0 ? -b : b)) / (2.0 * kStep_px);
  };
  Row row(value_.size());
  for (std::size_t i = 0; i < shapes_.size(); ++i)
    row[static_cast<Eigen::Index>(i)] = slope_of(table_.slope[shapes_[i]], true);
  row[real_] = -slope_of(table_.lsf, false);
  for (std::size_t j = 0; j < changes_.size(); ++j) row[place_of(j)] = change_slope(changes_[j], d_px);
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
  const auto [side, h, t] = between_knots(d_px);
  const double u = 1.0 - t;
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
