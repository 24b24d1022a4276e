// SPDX-License-Identifier: Apache-2.0
#include "calib/flat_bounds.h"

#include <algorithm>
#include <cmath>

namespace calib {
namespace {

// An effect that grows as u^p is p times as many linear standard deviations away from its bound as it is real ones.
constexpr double kNear_sd = 8.0;
constexpr double kNear_x = 20.0;      // in units of 0.05 of the OTF: further, no bound is within reach
constexpr double kFlat = 0.5;         // of the information, at half the distance; 1 where the effect is linear
constexpr double kSeen_sd = 1.0;      // u sqrt(S) of an effect to start from ...
constexpr double kClearly_sd = 30.0;  // ... within what the others can make good
constexpr double kUnseen_sd = 0.1;
constexpr double kSmallest_x = 1e-6;

/// The information of parameter i alone, the unknowns of each set of data projected out, at another x; NaN where the
/// sensor does not allow it.
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
    const auto i = static_cast<Eigen::Index>(i_);
    return information_of(*problem_, problem_->normals(), solved_->noise_factor)(i, i);
  }

 private:
  FitProblem* problem_;
  const Solved* solved_;
  std::size_t i_;
  double x_;
};

std::optional<FlatBound> flat_bound(FitProblem& problem, const Solved& solved, std::size_t i) {
  const Variable& v = problem.variables[i];
  if (v.period > 0.0 || v.squared) return std::nullopt;  // no bound; in proportion already
  const auto index = static_cast<Eigen::Index>(i);
  const double x = problem.x[i], sd = std::sqrt(solved.identified.covariance(index, index));
  const bool low = x - v.lo <= v.hi - x;
  const double away = low ? x - v.lo : v.hi - x, range = v.hi - v.lo;
  if (!(away < kNear_sd * sd && away < kNear_x)) return std::nullopt;

  FlatBound flat{.parameter = i, .bound = low ? v.lo : v.hi, .inward = low ? 1.0 : -1.0};
  const InformationAt information(problem, solved, i);
  const auto seen = [&](double u) { return u * std::sqrt(information(flat.bound + flat.inward * u)); };
  const double here = away * std::sqrt(solved.information(index, index));
  flat.reached = here < kUnseen_sd;
  flat.off = away;
  double effect = here;
  if (effect < kSeen_sd) {
    // Upwards: far out the effect may have come to its end.
    const double most = std::min(range, kNear_x);
    for (flat.off = kSmallest_x; !(effect >= kSeen_sd) && flat.off < most;)
      effect = seen(flat.off = std::min(4.0 * flat.off, most));
    while (effect > kClearly_sd) effect = seen(flat.off *= 0.5);
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

}  // namespace calib
