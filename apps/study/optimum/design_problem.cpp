// SPDX-License-Identifier: Apache-2.0
#include "apps/study/optimum/design_problem.h"

#include <algorithm>
#include <cmath>

namespace study {
namespace {

std::pair<double, double> ends_of(const Axis& axis) {
  if (axis.values.empty()) return std::minmax(axis.from, axis.to);
  const auto [lo, hi] = std::minmax_element(axis.values.begin(), axis.values.end());
  return {*lo, *hi};
}

double quantile_of(std::vector<double> values, double share) {
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(std::lround(share * static_cast<double>(values.size() - 1)))];
}

}  // namespace

std::shared_ptr<const Study> sharpened(const Study& study) {
  auto sharp = std::make_shared<Study>(study);
  sharp->tolerance = std::min(study.tolerance, kSharp);
  return sharp;
}

std::shared_ptr<const Study> only_needed(const Study& study) {
  std::vector<bool> needed(study.slots(), false);
  const auto use = [&](const Expression& expression) {
    for (const int slot : expression.slots()) needed[static_cast<std::size_t>(slot)] = true;
  };
  for (const Objective& objective : study.objectives) use(objective.expression);
  for (const Constraint& constraint : study.constraints) {
    use(constraint.left);
    use(constraint.right);
  }
  auto lean = std::make_shared<Study>(*sharpened(study));
  for (std::size_t i = 0; i < lean->metrics.size(); ++i)
    if (!needed[study.parameters.size() + i]) lean->metrics[i] = *find_metric("ifov");
  return lean;
}

DesignProblem::DesignProblem(std::shared_ptr<const Study> study, Goal goal, std::vector<int> levels)
    : study_(std::move(study)), goal_(std::move(goal)), levels_(std::move(levels)), evaluator_(study_) {
  for (std::size_t a = 0; a < study_->axes.size(); ++a) {
    const Axis& axis = study_->axes[a];
    if (axis.discrete()) continue;
    const auto [lo, hi] = ends_of(axis);
    if (lo < hi) {
      axes_.push_back(a);
      columns_.push_back(numeric_);
    }
    ++numeric_;
  }
  row_.resize(columns_of(*study_).size());
}

std::vector<double> DesignProblem::axis_values(std::span<const double> z) const {
  std::vector<double> values(study_->axes.size());
  for (std::size_t a = 0; a < values.size(); ++a)
    values[a] = study_->axes[a].discrete() ? levels_[a] : ends_of(study_->axes[a]).first;
  for (std::size_t i = 0; i < axes_.size(); ++i) {
    const auto [lo, hi] = ends_of(axis(i));
    const double between =
        axis(i).scale == Scale::log ? lo * std::exp(z[i] * std::log(hi / lo)) : lo * (1.0 - z[i]) + hi * z[i];
    values[axes_[i]] = z[i] <= 0.0 ? lo : z[i] >= 1.0 ? hi : std::clamp(between, lo, hi);
  }
  return values;
}

std::vector<double> DesignProblem::cube(std::span<const double> axis_values) const {
  std::vector<double> z(axes_.size());
  for (std::size_t i = 0; i < axes_.size(); ++i) {
    const auto [lo, hi] = ends_of(axis(i));
    const double x = axis_values[axes_[i]];
    z[i] =
        std::clamp(axis(i).scale == Scale::log ? std::log(x / lo) / std::log(hi / lo) : (x - lo) / (hi - lo), 0.0, 1.0);
  }
  return z;
}

double DesignProblem::stretch(std::size_t variable, double z) const {
  const auto [lo, hi] = ends_of(axis(variable));
  if (axis(variable).scale != Scale::log) return hi - lo;
  const double span = std::log(hi / lo);
  return lo * std::exp(z * span) * span;
}

DesignPoint DesignProblem::at(std::span<const double> z) {
  ++evaluations_;
  evaluator_.evaluate_at(axis_values(z), row_);
  DesignPoint point;
  for (std::size_t i = 0; i < goal_.size(); ++i)
    if (goal_[i] != 0.0) point.f += goal_[i] * evaluator_.last_objectives()[i];
  for (std::size_t j = 0; j < constraints(); ++j)
    point.margin.push_back(evaluator_.last_sides()[j].margin(study_->constraints[j].less));
  if (!std::isfinite(point.f)) point.f = std::numeric_limits<double>::quiet_NaN();
  return point;
}

DesignSlopes DesignProblem::slopes(std::span<const double> z) {
  const std::size_t n = variables();
  DesignSlopes slopes{std::vector<double>(n, 0.0), std::vector<double>(n * constraints(), 0.0)};
  if (n == 0) return slopes;
  ++evaluations_;
  const Gradient gradient = evaluator_.gradient_at(axis_values(z), kSharp);
  for (std::size_t i = 0; i < n; ++i) {
    const double by_z = stretch(i, z[i]);
    for (std::size_t k = 0; k < goal_.size(); ++k)
      if (goal_[k] != 0.0) slopes.f[i] += goal_[k] * gradient.objective[k * numeric_ + columns_[i]] * by_z;
    for (std::size_t j = 0; j < constraints(); ++j)
      slopes.margin[j * n + i] = gradient.margin[j * numeric_ + columns_[i]] * by_z;
  }
  return slopes;
}

bool DesignProblem::feasible(const DesignPoint& point) const {
  for (std::size_t j = 0; j < point.margin.size(); ++j)
    if (!std::isfinite(point.margin[j]) ||
        !(study_->constraints[j].strict ? point.margin[j] > 0.0 : point.margin[j] >= 0.0))
      return false;
  return std::isfinite(point.f);
}

ProblemScale scale_of(DesignProblem& problem, const std::vector<std::vector<double>>& points) {
  ProblemScale scale;
  std::vector<double> f;
  std::vector<std::vector<double>> sizes(problem.constraints());
  for (const auto& z : points) {
    const double value = problem.at(z).f;
    if (std::isfinite(value)) f.push_back(value);
    for (std::size_t j = 0; j < sizes.size(); ++j) {
      const ConstraintValues& sides = problem.sides()[j];
      const Constraint& constraint = problem.study().constraints[j];
      const double size = constraint.right.constant() && sides.right != 0.0 ? std::abs(sides.right)
                          : constraint.left.constant() && sides.left != 0.0
                              ? std::abs(sides.left)
                              : std::max(std::abs(sides.left), std::abs(sides.right));
      if (std::isfinite(size) && size > 0.0) sizes[j].push_back(size);
    }
  }
  for (const auto& size : sizes) scale.margin.push_back(size.empty() ? 1.0 : quantile_of(size, 0.5));
  if (f.empty()) return scale;
  scale.f_middle = quantile_of(f, 0.5);
  for (const double spread : {quantile_of(f, 0.75) - quantile_of(f, 0.25), quantile_of(f, 1.0) - quantile_of(f, 0.0),
                              std::abs(scale.f_middle), 1.0})
    if (spread > 0.0) {
      scale.f = spread;
      break;
    }
  return scale;
}

double violation(const DesignPoint& point, const ProblemScale& scale) {
  double worst = 0.0;
  for (std::size_t j = 0; j < point.margin.size(); ++j) {
    if (!std::isfinite(point.margin[j])) return HUGE_VAL;
    worst = std::max(worst, -point.margin[j] / scale.margin[j]);
  }
  return worst;
}

double total_violation(const DesignPoint& point, const ProblemScale& scale) {
  if (std::isinf(violation(point, scale))) return HUGE_VAL;
  double sum = 0.0;
  for (std::size_t j = 0; j < point.margin.size(); ++j) {
    const double short_of = std::max(0.0, -point.margin[j] / scale.margin[j]);
    sum += short_of * short_of;
  }
  return std::sqrt(sum);
}

}  // namespace study
