// SPDX-License-Identifier: Apache-2.0
#include "apps/study/optimum/smooth_search.h"

#include <ceres/first_order_function.h>
#include <ceres/gradient_problem.h>
#include <ceres/gradient_problem_solver.h>

#include <algorithm>
#include <cmath>

namespace study {
namespace {

constexpr double kSlopeLeft = 1e-9;
constexpr double kFarthestPenalty = 1e7;
/// Constraints are kept by this share of their scale, so that what ends at a limit is on the right side of it.
constexpr double kKeptOff = 1e-7;
constexpr double kGoodEnough = 2e-8;  // of violations; below kKeptOff

/// d asinh(x)/dx.
double asinh_slope(double x) { return 1.0 / std::hypot(1.0, x); }

double scaled_objective(const DesignPoint& point, const ProblemScale& scale) {
  return (point.f - scale.f_middle) / scale.f;
}
double scaled_margin(const DesignPoint& point, const ProblemScale& scale, std::size_t j) {
  return point.margin[j] / scale.margin[j] - kKeptOff;
}

std::vector<double> cube_of(std::span<const double> theta) {
  std::vector<double> z;
  for (const double t : theta) z.push_back(std::pow(std::sin(0.5 * t), 2));
  return z;
}

struct Multipliers {
  std::vector<double> value;
  double penalty = 10.0;
};

/// What one minimization has found so far.
struct Seen {
  std::vector<double> best;  // theta
  double least = HUGE_VAL;
  bool no_slopes = false;
};

/// f + sum of (max(0, m + p g)^2 - m^2) / (2 p), g the violations.
class AugmentedLagrangian final : public ceres::FirstOrderFunction {
 public:
  AugmentedLagrangian(DesignProblem& problem, const ProblemScale& scale, const SearchTask& task,
                      const Multipliers& multipliers, Seen& seen, int last_evaluation)
      : problem_(&problem),
        scale_(&scale),
        task_(task),
        multipliers_(&multipliers),
        seen_(&seen),
        last_evaluation_(last_evaluation) {}

  int NumParameters() const override { return static_cast<int>(problem_->variables()); }

  bool Evaluate(const double* theta, double* cost, double* gradient) const override {
    if (problem_->evaluations() >= last_evaluation_) return false;
    const std::size_t n = problem_->variables();
    const std::vector<double> z = cube_of({theta, n});
    const DesignPoint point = problem_->at(z);
    const bool sloped = gradient != nullptr;
    const DesignSlopes slopes = sloped ? problem_->slopes(z) : DesignSlopes{};
    std::vector<double> by_z(n, 0.0);
    double sum = 0.0;
    if (!task_.only_constraints) {
      sum = compressed_objective(point, *scale_);
      const double slope = asinh_slope(scaled_objective(point, *scale_)) / scale_->f;
      for (std::size_t i = 0; sloped && i < n; ++i) by_z[i] = slope * slopes.f[i];
    }
    for (std::size_t j = 0; j < point.margin.size(); ++j) {
      const double m = multipliers_->value[j], p = multipliers_->penalty;
      // The nearest design is that of the violations themselves.
      const double margin = scaled_margin(point, *scale_, j);
      const double pull = std::max(0.0, m + p * (task_.only_constraints ? -margin : -std::asinh(margin)));
      if (std::isnan(point.margin[j])) return false;
      sum += (pull * pull - m * m) / (2.0 * p);
      if (pull == 0.0) continue;
      const double slope = -pull * (task_.only_constraints ? 1.0 : asinh_slope(margin)) / scale_->margin[j];
      for (std::size_t i = 0; sloped && i < n; ++i) by_z[i] += slope * slopes.margin[j * n + i];
    }
    if (!std::isfinite(sum)) return false;
    for (std::size_t i = 0; sloped && i < n; ++i) {
      gradient[i] = by_z[i] * 0.5 * std::sin(theta[i]);
      if (std::isfinite(gradient[i])) continue;
      seen_->no_slopes = true;
      return false;
    }
    *cost = sum;
    if (sum < seen_->least) {
      seen_->least = sum;
      seen_->best.assign(theta, theta + n);
    }
    return true;
  }

 private:
  DesignProblem* problem_;
  const ProblemScale* scale_;
  SearchTask task_;
  const Multipliers* multipliers_;
  Seen* seen_;
  int last_evaluation_;
};

/// The best theta that was met; the start when there was none.
std::vector<double> minimize(DesignProblem& problem, const ProblemScale& scale, const SearchTask& task,
                             const Multipliers& multipliers, std::vector<double> theta, int last_evaluation,
                             double slope_left, bool& no_slopes) {
  Seen seen;
  const ceres::GradientProblem lagrangian(
      new AugmentedLagrangian(problem, scale, task, multipliers, seen, last_evaluation));  // which owns it
  ceres::GradientProblemSolver::Options options;
  options.line_search_direction_type = ceres::BFGS;
  options.use_approximate_eigenvalue_bfgs_scaling = true;
  options.line_search_interpolation_type = ceres::BISECTION;  // those of polynomials complain on standard error
  options.max_num_iterations = 200;
  options.gradient_tolerance = slope_left;
  options.function_tolerance = 1e-15;
  options.parameter_tolerance = 1e-14;
  options.min_line_search_step_size = 1e-14;
  options.logging_type = ceres::SILENT;
  ceres::GradientProblemSolver::Summary summary;
  const std::vector<double> start = theta;
  ceres::Solve(options, lagrangian, theta.data(), &summary);
  no_slopes = no_slopes || seen.no_slopes;
  return seen.best.empty() ? start : seen.best;
}

}  // namespace

double compressed_objective(const DesignPoint& point, const ProblemScale& scale) {
  return std::asinh(scaled_objective(point, scale));
}
double compressed_violation(const DesignPoint& point, const ProblemScale& scale, std::size_t constraint) {
  return -std::asinh(scaled_margin(point, scale, constraint));
}

SearchEnd smooth_search(DesignProblem& problem, const ProblemScale& scale, std::vector<double> z,
                        const SearchTask& task) {
  SearchEnd end;
  const int last_evaluation = problem.evaluations() + task.most_evaluations;
  std::vector<double> theta;
  // The start is moved off the ends, where theta has no slope.
  for (const double zi : z) theta.push_back(std::acos(1.0 - 2.0 * std::clamp(zi, 0.01, 0.99)));
  if (!std::isfinite(problem.at(cube_of(theta)).f) && !task.only_constraints)
    for (std::size_t i = 0; i < theta.size(); ++i) theta[i] = std::acos(1.0 - 2.0 * z[i]);
  Multipliers multipliers{std::vector<double>(problem.constraints(), 0.0)};
  double before = HUGE_VAL;
  for (int round = 0; round < 30 && problem.evaluations() < last_evaluation; ++round) {
    // Sharper as the multipliers become those of the optimum; without constraints there is but one round.
    const bool once = multipliers.value.empty() || task.only_constraints;
    const double slope_left = once ? kSlopeLeft : std::max(kSlopeLeft, 1e-3 * std::pow(0.1, round));
    theta = minimize(problem, scale, task, multipliers, theta, last_evaluation, slope_left, end.no_slopes);
    if (once) break;
    const DesignPoint point = problem.at(cube_of(theta));
    double worst = 0.0;
    for (std::size_t j = 0; j < point.margin.size(); ++j) {
      double& m = multipliers.value[j];
      const double g = compressed_violation(point, scale, j);
      worst = std::max(worst, std::abs(std::max(g, -m / multipliers.penalty)));
      m = std::max(0.0, m + multipliers.penalty * g);
    }
    if (!(worst > kGoodEnough) && slope_left < 1e-6) break;
    if (worst > 0.25 * before) {
      if (multipliers.penalty >= kFarthestPenalty && worst > 0.9 * before) break;
      multipliers.penalty = std::min(10.0 * multipliers.penalty, kFarthestPenalty);
    }
    before = worst;
  }
  end.z = cube_of(theta);
  return end;
}

}  // namespace study
