// SPDX-License-Identifier: Apache-2.0
#include "calib/series/series_minimum.h"

#include <ceres/ceres.h>

#include <algorithm>
#include <cmath>

#include "mtf/parallel.h"

namespace calib {
namespace {

constexpr int kRounds = 8, kIterationsOfRound = 8;

/// All residuals and those of the priors; one block of a single number for each variable, so that any can be held.
class SeriesCost final : public ceres::CostFunction {
 public:
  explicit SeriesCost(SeriesProblem& problem) : problem_(&problem) {
    int count = static_cast<int>(problem.measured.size());
    for (const auto& prior : problem.prior) count += prior.has_value();
    set_num_residuals(count);
    mutable_parameter_block_sizes()->assign(problem.x.size(), 1);
  }
  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override {
    const std::size_t n = problem_->x.size();
    std::vector<double> x(n);
    for (std::size_t i = 0; i < n; ++i) x[i] = *parameters[i];
    Eigen::Map<Eigen::VectorXd> out(residuals, num_residuals());
    const auto rows = static_cast<Eigen::Index>(problem_->measured.size());
    if (jacobians == nullptr) {
      const auto r = problem_->residuals(x);
      ++problem_->evaluations;
      if (!r) return false;
      out.head(rows) = problem_->weight * *r;
    } else {
      const auto linear = problem_->linear(x);
      if (!linear) return false;
      out.head(rows) = problem_->weight * linear->residual;
      for (std::size_t i = 0; i < n; ++i) {
        if (jacobians[i] == nullptr) continue;
        Eigen::Map<Eigen::VectorXd> column(jacobians[i], num_residuals());
        column.setZero();
        column.head(rows) = problem_->weight * linear->jacobian.col(static_cast<Eigen::Index>(i));
      }
    }
    Eigen::Index row = rows;
    for (std::size_t i = 0; i < n; ++i) {
      if (!problem_->prior[i]) continue;
      const auto [mean, sd] = *problem_->prior[i];
      out[row] = (problem_->scale[i] * x[i] - mean) / sd;
      if (jacobians != nullptr && jacobians[i] != nullptr) jacobians[i][row] = problem_->scale[i] / sd;
      ++row;
    }
    return true;
  }

 private:
  SeriesProblem* problem_;
};

SeriesMinimum minimise_holding(SeriesProblem& problem, const std::vector<bool>& held) {
  ceres::Problem ceres_problem;
  std::vector<double*> blocks;
  for (double& x : problem.x) blocks.push_back(&x);
  ceres_problem.AddResidualBlock(new SeriesCost(problem), nullptr, blocks);
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    ceres_problem.SetParameterLowerBound(blocks[i], 0, problem.lo[i]);
    ceres_problem.SetParameterUpperBound(blocks[i], 0, problem.hi[i]);
    if (held[i]) ceres_problem.SetParameterBlockConstant(blocks[i]);
  }
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_QR;
  options.num_threads = 1;
  options.logging_type = ceres::SILENT;
  options.max_num_iterations = kIterationsOfRound;
  // Correlated residuals are few facts: 1e-4 of the cost is less than a hundredth of what one standard deviation is.
  // A finer minimum would be one of the steps and cells that the model is solved with.
  options.function_tolerance = 1e-4;
  // Where bounds cut a step, Ceres searches along it: by values alone, which cost one solution each, not by gradients.
  options.line_search_interpolation_type = ceres::BISECTION;
  options.max_num_line_search_step_size_iterations = 4;
  options.parameter_tolerance = 1e-5;
  options.gradient_tolerance = 1e-10;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &ceres_problem, &summary);
  return {summary.termination_type == ceres::CONVERGENCE, static_cast<int>(summary.iterations.size())};
}

}  // namespace

std::vector<double> SeriesProblem::values(std::span<const double> at) const {
  std::vector<double> all;
  for (std::size_t i = 0; i < at.size(); ++i) all.push_back(scale[i] * at[i]);
  return all;
}

std::optional<Eigen::VectorXd> SeriesProblem::residuals(std::span<const double> at) const {
  const std::vector<double> whole = (*model)(values(at));
  if (whole.empty()) return std::nullopt;
  Eigen::VectorXd r(static_cast<Eigen::Index>(measured.size()));
  for (std::size_t i = 0; i < measured.size(); ++i) r[static_cast<Eigen::Index>(i)] = whole[place[i]] - measured[i];
  return r.allFinite() ? std::optional(std::move(r)) : std::nullopt;
}

std::optional<SeriesProblem::Linear> SeriesProblem::linear(std::span<const double> at, double difference) {
  const std::size_t n = at.size();
  // At the values themselves, then up and down for each variable.
  std::vector<std::vector<double>> points{std::vector<double>(at.begin(), at.end())};
  for (std::size_t i = 0; i < n; ++i)
    for (const double step : {difference, -difference}) {
      points.push_back(points.front());
      points.back()[i] = std::clamp(at[i] + step, lo[i], hi[i]);
    }
  std::vector<std::optional<Eigen::VectorXd>> r(points.size());
  mtf::parallel_for(static_cast<std::int64_t>(points.size()), 1, options.threads,
                    [&](std::int64_t first, std::int64_t last) {
                      for (auto p = static_cast<std::size_t>(first); p < static_cast<std::size_t>(last); ++p)
                        r[p] = residuals(points[p]);
                    });
  evaluations += static_cast<int>(points.size());
  if (options.progress) options.progress(evaluations);
  if (!r.front()) return std::nullopt;
  Linear linear{*r.front(), Eigen::MatrixXd::Zero(r.front()->size(), static_cast<Eigen::Index>(n))};
  for (std::size_t i = 0; i < n; ++i) {
    std::size_t up = 1 + 2 * i, down = up + 1;
    if (!r[up]) up = 0;
    if (!r[down]) down = 0;
    const double width = points[up][i] - points[down][i];
    if (width > 0.0) linear.jacobian.col(static_cast<Eigen::Index>(i)) = (*r[up] - *r[down]) / width;
  }
  return linear;
}

Eigen::VectorXd SeriesProblem::gradient(const Linear& linear) const {
  Eigen::VectorXd g = weight * weight * linear.jacobian.transpose() * linear.residual;
  for (std::size_t i = 0; i < x.size(); ++i)
    if (prior[i]) {
      const auto [mean, sd] = *prior[i];
      g[static_cast<Eigen::Index>(i)] += (scale[i] * x[i] - mean) / sd * scale[i] / sd;
    }
  return g;
}

SeriesMinimum minimise(SeriesProblem& problem) {
  const std::size_t n = problem.x.size();
  std::vector<bool> held(n, false);
  SeriesMinimum minimum;
  // The minimiser cuts its steps at bounds, and creeps along them; with what presses against a bound held there it does
  // not.
  for (int round = 0; round < kRounds; ++round) {
    const int before = minimum.iterations;
    minimum = minimise_holding(problem, held);
    minimum.iterations += before;
    const auto linear = problem.linear(problem.x);
    if (!linear) break;
    const Eigen::VectorXd g = problem.gradient(*linear);
    bool changed = false;
    for (std::size_t i = 0; i < n; ++i) {
      const auto index = static_cast<Eigen::Index>(i);
      const double near = 1e-6 * std::max(1.0, std::abs(problem.x[i]));
      const bool low = problem.x[i] - problem.lo[i] < near, high = problem.hi[i] - problem.x[i] < near;
      const bool pressed = (low && g[index] > 0.0) || (high && g[index] < 0.0);
      changed = changed || pressed != held[i];
      held[i] = pressed;
    }
    if (std::all_of(held.begin(), held.end(), [](bool one) { return one; }))
      minimum.converged = true;
    else if (changed || !minimum.converged)
      continue;
    break;
  }
  return minimum;
}

}  // namespace calib
