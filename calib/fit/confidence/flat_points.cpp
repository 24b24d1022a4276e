// SPDX-License-Identifier: Apache-2.0
#include "calib/fit/confidence/flat_points.h"

#include <algorithm>
#include <cmath>

namespace calib {
namespace {

// An effect that grows as u^p, at k linear standard deviations from its bound, has an interval that is lopsided by
// 0.98 (p - 1) / k of its half: a tenth at 10 (p - 1). The third power is the highest that components have.
constexpr double kNear_sd = 20.0;
constexpr double kNear_x = 20.0;          // in units of 0.05 of the OTF: a bound further away does not matter
constexpr double kFlat = 0.5;             // of the information, at half the distance; 1 where the effect is linear
constexpr double kSeen_sd = 1.0;          // u sqrt(S) of an effect to start from ...
constexpr double kClearEffect_sd = 30.0;  // ... within what the others can compensate for
constexpr double kUnseen_sd = 0.1;
constexpr double kMadeGood = 10.0;  // ratio of the variances of a square with its partners unknown and known
constexpr double kSmallest_x = 1e-6;

/// The information of parameter i alone, the unknowns of each set of data projected out, at another x; of a square, in
/// which the effect of the parameter itself is in proportion, that which its partners leave. NaN where the sensor does
/// not allow it.
class InformationAt {
 public:
  InformationAt(SomeBlocks& some, std::size_t i)
      : problem_(&some.problem), solved_(&some.solved), i_(i), x_(some.problem.x[i]), of_all_(1.0 / some.share) {}
  InformationAt(const InformationAt&) = delete;
  InformationAt& operator=(const InformationAt&) = delete;
  ~InformationAt() {
    problem_->x[i_] = x_;
    problem_->apply();
  }
  double operator()(double x) const {
    problem_->x[i_] = x;
    if (!problem_->apply()) return std::nan("");
    const std::vector<Eigen::MatrixXd> normals = problem_->normals();
    if (!std::ranges::all_of(normals, [](const auto& one) { return one.allFinite(); })) return std::nan("");
    return of_all_ * left_of(information_of(*problem_, normals, problem_->score_covariances(noise_of(solved_->tests)),
                                            solved_->noise_factor)
                                 .matrix);
  }
  double left_of(const Eigen::MatrixXd& information) const {
    const auto i = static_cast<Eigen::Index>(i_);
    if (!problem_->variables[i_].squared) return information(i, i);
    return 1.0 / identify(information, solved_->reference).covariance(i, i);
  }

 private:
  FitProblem* problem_;
  const Solved* solved_;
  std::size_t i_;
  double x_;
  double of_all_;  ///< information of all blocks, in that of these
};

/// Vertex of the parabola through the information at x - h, x, x + h; none where that has no least value.
std::optional<double> least_information(const InformationAt& information, double x, double h) {
  const double below = information(x - h), here = information(x), above = information(x + h);
  const double bend = below - 2.0 * here + above;
  if (!(bend > 0.0)) return std::nullopt;
  return x + 0.5 * h * (below - above) / bend;
}

/// `told_apart`: each of many sets of data sees a term over the field at another size, and no centre but 0 is that of
/// all.
std::vector<double> centres(const InformationAt& information, const Variable& v, double x, double sd, bool told_apart) {
  constexpr double kDirection_deg = 5.0, kFarthest = 10.0;  // steps
  std::vector<double> all;
  if (!v.has_sign() && !v.direction) return all;
  if (v.has_sign()) all.push_back(0.0);
  if (told_apart) return all;
  const double h = v.direction ? kDirection_deg / v.step : 0.5 * std::min(sd, std::max(1.0, 0.1 * std::abs(x)));
  const auto near = least_information(information, x, h);
  if (!near || std::abs(*near - x) > kFarthest * std::max(h, std::abs(x))) return all;
  const auto best = least_information(information, *near, std::max(0.25 * h, 0.5 * std::abs(*near - x)));
  if (best && *best > v.lo && *best < v.hi) all.push_back(*best);
  return all;
}

/// `point`: flat, or not; where it is, with its distances.
std::optional<FlatPoint> if_flat(const InformationAt& information, FlatPoint point, double range, double x, double sd,
                                 double information_here) {
  const double away = std::abs(x - point.at);
  const auto seen = [&](double u) { return u * std::sqrt(information(point.at + point.side * u)); };
  const double here = away * std::sqrt(information_here);
  point.here = here < kUnseen_sd || away < sd;
  point.off = away;
  double effect = here;
  if (effect < kSeen_sd) {
    // The search goes upwards, as far from the point the effect may have saturated.
    const double most = std::min(range, kNear_x);
    for (point.off = kSmallest_x; !(effect >= kSeen_sd) && point.off < most;)
      effect = seen(point.off = std::min(4.0 * point.off, most));
    while (effect > kClearEffect_sd) effect = seen(point.off *= 0.5);
  }
  if (!(effect >= kSeen_sd)) return std::nullopt;  // no effect at all, or none that can be computed
  const double half = seen(0.5 * point.off);
  // Both are u sqrt(S).
  return 4.0 * half * half < kFlat * effect * effect ? std::optional(point) : std::nullopt;
}

std::optional<FlatPoint> flat_point(SomeBlocks& some, std::size_t i) {
  constexpr double kQuarter_deg = 45.0;  // of the way from a direction that acts most to the next one
  const Solved& solved = some.solved;
  const Variable& v = some.problem.variables[i];
  const auto index = static_cast<Eigen::Index>(i);
  const double x = some.problem.x[i], sd = std::sqrt(solved.identified.covariance(index, index));
  // The effect of a square is linear in it, or quadratic where its partners can compensate for the linear part. Where
  // it is undetermined then, it is reported as such.
  const bool made_good = sd * sd * solved.information.matrix(index, index) > kMadeGood;
  if (v.squared && !(made_good && solved.identified.determined[i])) return std::nullopt;
  const InformationAt information(some, i);
  const double here = information.left_of(solved.information.matrix);
  const bool low = x - v.lo <= v.hi - x;
  const double away = low ? x - v.lo : v.hi - x;
  if (v.period == 0.0 && away < kNear_sd * sd && away < kNear_x) {
    const FlatPoint bound{.parameter = i, .at = low ? v.lo : v.hi, .side = low ? 1.0 : -1.0};
    if (const auto flat = if_flat(information, bound, v.hi - v.lo, x, sd, here)) return flat;
  }
  for (const double at : centres(information, v, x, sd, some.told_apart[i])) {
    if (!(std::abs(x - at) < kNear_sd * sd)) continue;
    const FlatPoint centre{.parameter = i, .at = at, .side = x < at ? -1.0 : 1.0, .inside = true};
    const double range = v.direction ? kQuarter_deg / v.step : x < at ? at - v.lo : v.hi - at;
    if (const auto flat = if_flat(information, centre, range, x, sd, here)) return flat;
  }
  return std::nullopt;
}

}  // namespace

double FlatPoint::off_point(double x) const { return std::abs(x - at) < off ? at + side * off : x; }

std::vector<FlatPoint> flat_points(const FitProblem& problem, const Solved& solved) {
  SomeBlocks some = some_blocks(problem, solved);
  std::vector<FlatPoint> all;
  for (std::size_t i = 0; i < problem.variables.size(); ++i)
    if (const auto flat = flat_point(some, i)) all.push_back(*flat);
  return all;
}

std::vector<double> possible_centres(SomeBlocks& some, std::size_t i) {
  const auto index = static_cast<Eigen::Index>(i);
  return centres(InformationAt(some, i), some.problem.variables[i], some.problem.x[i],
                 std::sqrt(some.solved.identified.covariance(index, index)), some.told_apart[i]);
}

void set_apart(Solved& solved, std::span<const FlatPoint> flat) {
  for (const FlatPoint& f : flat) {
    if (!f.here) continue;
    const auto i = static_cast<Eigen::Index>(f.parameter);
    for (Eigen::MatrixXd* information : {&solved.information.matrix, &solved.information.independent}) {
      const double own = (*information)(i, i);
      information->row(i).setZero();
      information->col(i).setZero();
      (*information)(i, i) = own;
    }
  }
  const auto here = [](const FlatPoint& f) { return f.here; };
  if (std::ranges::any_of(flat, here)) identify(solved);
}

}  // namespace calib
