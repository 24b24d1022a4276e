// SPDX-License-Identifier: Apache-2.0
#include "calib/fit/fit_problem.h"

#include <ceres/ceres.h>
#include <algorithm>
#include <cmath>
#include <limits>

#include "mtf/error.h"
#include "mtf/parallel.h"

namespace calib {
namespace {

using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// All unknowns in one allocation: Ceres orders them by their addresses. Very large values are divided by a power of
/// two, as Ceres judges steps by the length of the vector of all unknowns.
class Unknowns {
 public:
  explicit Unknowns(FitProblem& problem) : problem_(&problem) {
    for (const auto& own : problem.own) all_.insert(all_.end(), own.begin(), own.end());
    all_.insert(all_.end(), problem.x.begin(), problem.x.end());
    const auto shared = all_.end() - std::ssize(problem.x);
    for (auto value = all_.begin(); value != all_.end(); ++value) {
      constexpr double kVast = 1e6;
      const bool vast = value < shared && std::abs(*value) > kVast && std::isfinite(*value);
      scale_.push_back(vast ? std::exp2(std::ilogb(*value)) : 1.0);
      *value /= scale_.back();
    }
    double* place = all_.data();
    for (const auto& own : problem.own) {
      own_.push_back(place);
      place += own.size();
    }
    x_ = place;
    // Gradients of plateaus are in the unit of these, and 0 to begin with.
    constexpr std::ptrdiff_t kGradients = 4;
    for (std::size_t b = 0; b < problem.blocks.size(); ++b) {
      const auto* edge = std::get_if<EdgeBlock>(&problem.blocks[b]);
      if (edge == nullptr || !edge->gradients()) continue;
      const auto first = scale_.begin() + (own_[b] - all_.data()), end = first + std::ssize(problem.own[b]);
      const double unit = *std::max_element(first, end - kGradients);
      for (auto scale = end - kGradients; scale != end; ++scale) {
        all_[static_cast<std::size_t>(scale - scale_.begin())] *= *scale / unit;
        *scale = unit;
      }
    }
  }
  double* own(std::size_t block) const { return own_[block]; }
  double* x() const { return x_; }
  double scale(std::size_t block, Eigen::Index i) const {
    return scale_[static_cast<std::size_t>(own_[block] - all_.data() + i)];
  }
  /// What Ceres has written goes to the problem; false when it is there already.
  bool give_back() const {
    bool any = false;
    const auto give = [&](const double* from, std::vector<double>& to) {
      const double* scale = scale_.data() + (from - all_.data());
      for (double& number : to) {
        const double value = *from++ * *scale++;
        any = any || number != value;
        number = value;
      }
    };
    for (std::size_t b = 0; b < own_.size(); ++b) give(own_[b], problem_->own[b]);
    give(x_, problem_->x);
    return any;
  }

 private:
  FitProblem* problem_;
  std::vector<double> all_, scale_;
  std::vector<double*> own_;
  double* x_ = nullptr;
};

/// Everything at the point that Ceres asks for, before it asks for the blocks one by one.
class Evaluator final : public ceres::EvaluationCallback {
 public:
  Evaluator(FitProblem& problem, const Unknowns& unknowns)
      : problem_(&problem), unknowns_(&unknowns), factors_(problem.blocks.size()) {}

  void PrepareForEvaluation(bool /*evaluate_jacobians*/, bool new_point) override {
    if ((!new_point || !unknowns_->give_back()) && prepared_) return;
    prepared_ = true;
    allowed_ = problem_->apply();
    if (!allowed_) return;
    const std::vector<Eigen::MatrixXd> normals = problem_->normals();
    for (std::size_t b = 0; b < normals.size(); ++b) {
      factors_[b] = triangular_factor(normals[b]);
      allowed_ = allowed_ && factors_[b].allFinite();
    }
  }
  bool allowed() const { return allowed_; }
  const Eigen::MatrixXd& factor(std::size_t block) const { return factors_[block]; }
  const Unknowns& unknowns() const { return *unknowns_; }

 private:
  FitProblem* problem_;
  const Unknowns* unknowns_;
  std::vector<Eigen::MatrixXd> factors_;
  bool prepared_ = false, allowed_ = false;
};

class BlockCost final : public ceres::CostFunction {
 public:
  BlockCost(const Evaluator& evaluator, std::size_t block, std::size_t own, std::size_t shared)
      : evaluator_(&evaluator), block_(block) {
    set_num_residuals(static_cast<int>(own + shared + 1));
    if (own > 0) mutable_parameter_block_sizes()->push_back(static_cast<int>(own));
    mutable_parameter_block_sizes()->push_back(static_cast<int>(shared));
  }
  bool Evaluate(double const* const*, double* residuals, double** jacobians) const override {
    if (!evaluator_->allowed()) return false;
    const Eigen::MatrixXd& factor = evaluator_->factor(block_);
    const Eigen::Index last = factor.cols() - 1;
    Eigen::Map<Eigen::VectorXd>(residuals, factor.rows()) = factor.col(last);
    Eigen::Index first = 0;
    for (std::size_t p = 0; p < parameter_block_sizes().size(); ++p) {
      const Eigen::Index size = parameter_block_sizes()[p];
      if (jacobians != nullptr && jacobians[p] != nullptr) {
        Eigen::Map<RowMajor> by(jacobians[p], factor.rows(), size);
        by = factor.middleCols(first, size);
        if (p + 1 < parameter_block_sizes().size())  // the block's own
          for (Eigen::Index i = 0; i < size; ++i)
            if (const double scale = evaluator_->unknowns().scale(block_, i); scale != 1.0) by.col(i) *= scale;
      }
      first += size;
    }
    return true;
  }

 private:
  const Evaluator* evaluator_;
  std::size_t block_;
};

/// (value - mean) / sd of every parameter with a prior.
class PriorCost final : public ceres::CostFunction {
 public:
  explicit PriorCost(const FitProblem& problem) : problem_(&problem) {
    int count = 0;
    for (const auto& prior : problem.priors) count += prior.has_value();
    set_num_residuals(count);
    mutable_parameter_block_sizes()->push_back(static_cast<int>(problem.variables.size()));
  }
  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override {
    const std::size_t n = problem_->variables.size();
    double* row = jacobians != nullptr ? jacobians[0] : nullptr;
    for (std::size_t i = 0; i < n; ++i) {
      if (!problem_->priors[i]) continue;
      const auto [mean, sd] = *problem_->priors[i];
      const Variable& variable = problem_->variables[i];
      *residuals++ = (variable.value(parameters[0][i]) - mean) / sd;
      if (row == nullptr) continue;
      std::fill_n(row, n, 0.0);
      row[i] = variable.slope(parameters[0][i]) / sd;
      row += n;
    }
    return true;
  }

 private:
  const FitProblem* problem_;
};

class Asks final : public ceres::IterationCallback {
 public:
  explicit Asks(const std::function<bool()>& go_on) : go_on_(&go_on) {}
  ceres::CallbackReturnType operator()(const ceres::IterationSummary&) override {
    return !*go_on_ || (*go_on_)() ? ceres::SOLVER_CONTINUE : ceres::SOLVER_ABORT;
  }

 private:
  const std::function<bool()>* go_on_;
};

/// Derivatives by the parameters, whose rows and columns end at `end`, become those by the variables.
void to_variables(const FitProblem& problem, Eigen::Index end, Eigen::MatrixXd& products) {
  for (std::size_t i = 0; i < problem.variables.size(); ++i) {
    const Eigen::Index column = end - static_cast<Eigen::Index>(problem.variables.size() - i);
    const double slope = problem.variables[i].slope(problem.x[i]);
    products.row(column) *= slope;
    products.col(column) *= slope;
  }
}

/// One run of the minimiser, with the `held` variables as they are.
Solution solve_holding(FitProblem& problem, const SolveOptions& asked, const std::vector<int>& held) {
  const Unknowns unknowns(problem);
  Evaluator evaluator(problem, unknowns);
  ceres::Problem::Options problem_options;
  problem_options.evaluation_callback = &evaluator;
  ceres::Problem ceres_problem(problem_options);
  const std::size_t n = problem.variables.size();
  double* const x = unknowns.x();

  auto ordering = std::make_shared<ceres::ParameterBlockOrdering>();
  for (std::size_t b = 0; b < problem.blocks.size(); ++b) {
    std::vector<double*> parameters;
    if (!problem.own[b].empty()) parameters.push_back(unknowns.own(b));
    parameters.push_back(x);
    ceres_problem.AddResidualBlock(new BlockCost(evaluator, b, problem.own[b].size(), n), nullptr, parameters);
    if (!problem.own[b].empty()) ordering->AddElementToGroup(unknowns.own(b), 0);
  }
  ordering->AddElementToGroup(x, 1);
  if (std::any_of(problem.priors.begin(), problem.priors.end(), [](const auto& p) { return p.has_value(); }))
    ceres_problem.AddResidualBlock(new PriorCost(problem), nullptr, x);
  for (std::size_t i = 0; i < n; ++i) {
    ceres_problem.SetParameterLowerBound(x, static_cast<int>(i), problem.variables[i].lo);
    ceres_problem.SetParameterUpperBound(x, static_cast<int>(i), problem.variables[i].hi);
  }
  if (held.size() == n)
    ceres_problem.SetParameterBlockConstant(x);
  else if (!held.empty())
    ceres_problem.SetManifold(x, new ceres::SubsetManifold(static_cast<int>(n), held));

  ceres::Solver::Options options;
  constexpr std::size_t kFewBlocks = 4;  // beyond, eliminating each block's own unknowns first is quicker
  options.linear_solver_type = problem.blocks.size() > kFewBlocks ? ceres::DENSE_SCHUR : ceres::DENSE_QR;
  if (options.linear_solver_type == ceres::DENSE_SCHUR) options.linear_solver_ordering = ordering;
  options.num_threads = 1;
  options.logging_type = ceres::SILENT;
  options.max_num_iterations = 100;
  // A step along a weak direction is not to be held back for long.
  options.initial_trust_region_radius = 1e6;
  options.function_tolerance = asked.tolerance;
  options.gradient_tolerance = 1e-14;
  options.parameter_tolerance = 1e-11;
  options.update_state_every_iteration = false;
  Asks asks(asked.go_on);
  options.callbacks.push_back(&asks);
  evaluator.PrepareForEvaluation(true, true);
  if (!evaluator.allowed()) {  // nowhere to start from
    Solution none;
    none.cost = std::numeric_limits<double>::infinity();
    return none;
  }
  ceres::Solver::Summary summary;
  ceres::Solve(options, &ceres_problem, &summary);
  unknowns.give_back();
  bool cut_off = false;
  for (std::size_t i = 0; i < n; ++i)  // back from rounds
    if (const Variable& v = problem.variables[i]; v.period > 0.0) {
      cut_off = cut_off || problem.x[i] <= v.lo || problem.x[i] >= v.hi;
      problem.x[i] = v.value(problem.x[i]) / v.step;
    }
  problem.apply();
  return {.converged = summary.termination_type == ceres::CONVERGENCE,
          .stopped = summary.termination_type == ceres::USER_FAILURE,
          .cost = summary.final_cost,
          .iterations = static_cast<int>(summary.iterations.size()),
          .cut_off = cut_off};
}

// A minimum at bounds. The minimiser cuts its steps where they leave the allowed range, and so leaves the other
// variables at values that compensate for what lies beyond, or takes many steps to bring them back. With the variables
// on their bounds held there, the others come to their minimum in a few steps.

bool at_bound(const FitProblem& problem, std::size_t i) {
  const Variable& v = problem.variables[i];
  return v.period == 0.0 && (problem.x[i] <= v.lo || problem.x[i] >= v.hi);
}

/// Of variables on their bounds those that the cost holds there: it does not fall away from the bound, but for
/// rounding.
std::vector<int> pressed(const FitProblem& problem, std::vector<int> bounded) {
  constexpr double kPull_sd = 0.01;
  if (bounded.empty() || !problem.apply()) return {};
  const std::vector<Eigen::MatrixXd> normals = problem.normals();
  std::erase_if(bounded, [&](int index) {
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
  return bounded;
}

}  // namespace

std::vector<Residual> FitProblem::residuals(std::size_t b, std::size_t every) const {
  if (const auto* edge = std::get_if<EdgeBlock>(&blocks[b])) return edge->residuals(*sensors, own[b], every);
  return std::visit([&](const auto& block) { return block.residuals(*sensors, own[b]); }, blocks[b]);
}

std::vector<Eigen::MatrixXd> FitProblem::normals(bool gradients) const {
  std::vector<Eigen::MatrixXd> all(blocks.size());
  const auto normal_of = [&](std::size_t b) {
    if (const auto* edge = std::get_if<EdgeBlock>(&blocks[b]); edge != nullptr && gradients)
      return edge->normal_with_gradients(*sensors, own[b]).matrix();
    return std::visit([&](const auto& block) { return block.normal(*sensors, own[b]).matrix(); }, blocks[b]);
  };
  mtf::parallel_for(static_cast<std::int64_t>(blocks.size()), 1, threads, [&](std::int64_t first, std::int64_t last) {
    for (auto b = static_cast<std::size_t>(first); b < static_cast<std::size_t>(last); ++b) {
      try {
        all[b] = normal_of(b);
      } catch (const mtf::Error&) {  // data that cannot be modelled there: the step is not allowed
        const auto* edge = std::get_if<EdgeBlock>(&blocks[b]);
        const std::size_t added = edge != nullptr && gradients && !edge->gradients() ? 4 : 0;
        const auto columns = static_cast<Eigen::Index>(own[b].size() + variables.size() + 1 + added);
        all[b] = Eigen::MatrixXd::Constant(columns, columns, std::numeric_limits<double>::quiet_NaN());
        continue;
      }
      to_variables(*this, all[b].cols() - 1, all[b]);
    }
  });
  return all;
}

std::vector<Eigen::MatrixXd> FitProblem::score_covariances(std::span<const NoiseCorrelation> noise) const {
  std::vector<Eigen::MatrixXd> all(blocks.size());
  mtf::parallel_for(static_cast<std::int64_t>(blocks.size()), 1, threads, [&](std::int64_t first, std::int64_t last) {
    for (auto b = static_cast<std::size_t>(first); b < static_cast<std::size_t>(last); ++b) {
      const auto* edge = std::get_if<EdgeBlock>(&blocks[b]);
      if (edge == nullptr || noise[b].white()) continue;
      all[b] = edge->score_covariance(*sensors, own[b], noise[b]);
      to_variables(*this, all[b].cols(), all[b]);
    }
  });
  return all;
}

Solution solve(FitProblem& problem, const SolveOptions& asked) {
  const auto at_bounds = [&] {
    std::vector<int> all;
    for (std::size_t i = 0; i < problem.x.size(); ++i)
      if (i != asked.fixed && at_bound(problem, i)) all.push_back(static_cast<int>(i));
    return all;
  };
  Solution solution;
  const auto go_on_holding = [&](std::vector<int> held) {
    if (asked.fixed) held.push_back(static_cast<int>(*asked.fixed));
    for (int round = 0; round == 0 || (solution.cut_off && round < 3); ++round) {
      const int before = solution.iterations;
      solution = solve_holding(problem, asked, held);
      solution.iterations += before;
    }
  };
  // Where a fit begins on bounds that it would press against, as a blur of 0 that the data do not show, it stays there.
  if (const std::vector<int> held = pressed(problem, at_bounds()); !held.empty()) {
    go_on_holding(held);
    if (solution.stopped || (solution.converged && at_bounds() == held && pressed(problem, held) == held))
      return solution;
  }
  go_on_holding({});
  for (int round = 0; round < 2 && solution.converged; ++round) {
    const std::vector<int> held = at_bounds();
    if (held.empty()) break;
    go_on_holding(held);
    if (round > 0 || !solution.converged || pressed(problem, held) == held) break;
    go_on_holding({});
  }
  return solution;
}

}  // namespace calib
