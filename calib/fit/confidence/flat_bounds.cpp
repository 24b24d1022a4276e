// SPDX-License-Identifier: Apache-2.0
#include "calib/fit/confidence/flat_bounds.h"

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
  InformationAt(FitProblem& problem, const Solved& solved, std::size_t i)
      : problem_(&problem), solved_(&solved), i_(i), x_(problem.x[i]) {}
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
    if (!std::all_of(normals.begin(), normals.end(), [](const auto& one) { return one.allFinite(); }))
      return std::nan("");
    return left_of(
        information_of(*problem_, normals, problem_->score_covariances(noise_of(solved_->tests)), solved_->noise_factor)
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
};

std::optional<FlatBound> flat_bound(FitProblem& problem, const Solved& solved, std::size_t i) {
  const Variable& v = problem.variables[i];
  if (v.period > 0.0) return std::nullopt;  // no bound
  const auto index = static_cast<Eigen::Index>(i);
  const double x = problem.x[i], sd = std::sqrt(solved.identified.covariance(index, index));
  // The effect of a square is linear in it, or quadratic where its partners can compensate for the linear part. Where
  // it is undetermined then, it is reported as such.
  const bool made_good = sd * sd * solved.information.matrix(index, index) > kMadeGood;
  if (v.squared && !(made_good && solved.identified.determined[i])) return std::nullopt;
  const bool low = x - v.lo <= v.hi - x;
  const double away = low ? x - v.lo : v.hi - x, range = v.hi - v.lo;
  if (!(away < kNear_sd * sd && away < kNear_x)) return std::nullopt;

  FlatBound flat{.parameter = i, .bound = low ? v.lo : v.hi, .inward = low ? 1.0 : -1.0};
  const InformationAt information(problem, solved, i);
  const auto seen = [&](double u) { return u * std::sqrt(information(flat.bound + flat.inward * u)); };
  const double here = away * std::sqrt(information.left_of(solved.information.matrix));
  flat.at_bound = here < kUnseen_sd || away < sd;
  flat.off = away;
  double effect = here;
  if (effect < kSeen_sd) {
    // The search goes upwards, as far from the bound the effect may have saturated.
    const double most = std::min(range, kNear_x);
    for (flat.off = kSmallest_x; !(effect >= kSeen_sd) && flat.off < most;)
      effect = seen(flat.off = std::min(4.0 * flat.off, most));
    while (effect > kClearEffect_sd) effect = seen(flat.off *= 0.5);
  }
  if (!(effect >= kSeen_sd)) return std::nullopt;  // no effect at all, or none that can be computed
  const double half = seen(0.5 * flat.off);
  // Both are u sqrt(S).
  return 4.0 * half * half < kFlat * effect * effect ? std::optional(flat) : std::nullopt;
}

}  // namespace

double FlatBound::off_bound(double x) const { return (x - bound) * inward < off ? bound + inward * off : x; }

std::vector<FlatBound> flat_bounds(FitProblem& problem, const Solved& solved) {
  std::vector<FlatBound> all;
  for (std::size_t i = 0; i < problem.variables.size(); ++i)
    if (const auto flat = flat_bound(problem, solved, i)) all.push_back(*flat);
  return all;
}

void set_apart(Solved& solved, std::span<const FlatBound> flat) {
  for (const FlatBound& f : flat) {
    if (!f.at_bound) continue;
    const auto i = static_cast<Eigen::Index>(f.parameter);
    for (Eigen::MatrixXd* information : {&solved.information.matrix, &solved.information.independent}) {
      const double own = (*information)(i, i);
      information->row(i).setZero();
      information->col(i).setZero();
      (*information)(i, i) = own;
    }
  }
  const auto at_bound = [](const FlatBound& f) { return f.at_bound; };
  if (std::any_of(flat.begin(), flat.end(), at_bound)) identify(solved);
}

}  // namespace calib
