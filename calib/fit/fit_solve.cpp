// SPDX-License-Identifier: Apache-2.0

// A minimum at bounds. The minimiser cuts its steps where they leave the allowed range, and so leaves the other
// variables at values that compensate for what lies beyond, or takes many steps to bring them back. With the variables
// on their bounds held there, the others come to their minimum in a few steps.

#include <algorithm>
#include <cmath>

#include "calib/fit/fit_problem.h"

namespace calib {
namespace {

bool at_bound(const FitProblem& problem, std::size_t i) {
  const Variable& v = problem.variables[i];
  return v.period == 0.0 && (problem.x[i] <= v.lo || problem.x[i] >= v.hi);
}

/// Whether the cost falls away from the bound of one of these variables, by more than rounding.
bool any_leaves(const FitProblem& problem, const std::vector<int>& held) {
  constexpr double kPull_sd = 0.01;
  const std::vector<Eigen::MatrixXd> normals = problem.normals();
  return std::any_of(held.begin(), held.end(), [&](int index) {
    const auto i = static_cast<std::size_t>(index);
    double gradient = 0.0, information = 0.0;
    for (std::size_t b = 0; b < normals.size(); ++b) {
      const Eigen::Index row = std::ssize(problem.own[b]) + index;
      gradient += normals[b](row, normals[b].cols() - 1);
      information += normals[b](row, row);
    }
    if (problem.priors[i]) {
      const auto [mean, sd] = *problem.priors[i];
      const double slope = problem.variables[i].slope(problem.x[i]) / sd;
      gradient += (problem.variables[i].value(problem.x[i]) - mean) / sd * slope;
      information += slope * slope;
    }
    const double inward = problem.x[i] <= problem.variables[i].lo ? -gradient : gradient;
    return inward > kPull_sd * std::sqrt(information);
  });
}

}  // namespace

Solution solve(FitProblem& problem, const SolveOptions& asked) {
  std::vector<int> fixed;
  if (asked.fixed) fixed.push_back(static_cast<int>(*asked.fixed));
  const auto at_bounds = [&] {
    std::vector<int> all;
    for (std::size_t i = 0; i < problem.x.size(); ++i)
      if (i != asked.fixed && at_bound(problem, i)) all.push_back(static_cast<int>(i));
    return all;
  };
  Solution solution;
  const auto go_on_holding = [&](std::vector<int> held) {
    held.insert(held.end(), fixed.begin(), fixed.end());
    for (int round = 0; round == 0 || (solution.cut_off && round < 3); ++round) {
      const int before = solution.iterations;
      solution = solve_holding(problem, asked, held);
      solution.iterations += before;
    }
  };
  go_on_holding({});
  for (int round = 0; round < 2 && solution.converged; ++round) {
    const std::vector<int> held = at_bounds();
    if (held.empty()) break;
    go_on_holding(held);
    if (round > 0 || !solution.converged || !any_leaves(problem, held)) break;
    go_on_holding({});
  }
  return solution;
}

}  // namespace calib
