// SPDX-License-Identifier: Apache-2.0
#include "calib/series/series_fit.h"

#include <ceres/ceres.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "calib/dense.h"
#include "calib/fit/confidence/identifiability.h"
#include "calib/fit/fit_report.h"
#include "mtf/error.h"
#include "mtf/parallel.h"
#include "mtf/units.h"
#include "mtf/words.h"

namespace calib {
namespace {

// The least squares of a series by Ceres, in x = value / scale.

inline constexpr double kDifference = 0.03;  ///< of the scale

struct SeriesProblem {
  std::vector<double> measured;                             ///< those that are there
  std::vector<std::size_t> place;                           ///< of each in the series
  std::vector<double> scale, lo, hi;                        ///< of x: value = scale x
  std::vector<std::optional<std::array<double, 2>>> prior;  ///< mean and sd of the values
  const SeriesModel* model = nullptr;
  SeriesFitOptions options;
  double weight = 1.0;  ///< of a residual: 1 / sd

  std::vector<double> x;
  int evaluations = 0;

  std::vector<double> values(std::span<const double> at) const {
    std::vector<double> all;
    for (std::size_t i = 0; i < at.size(); ++i) all.push_back(scale[i] * at[i]);
    return all;
  }
  /// Residuals, model - measured without weight; absent where the model allows no such values.
  std::optional<Eigen::VectorXd> residuals(std::span<const double> at) const {
    const std::vector<double> whole = (*model)(values(at));
    if (whole.empty()) return std::nullopt;
    Eigen::VectorXd r(static_cast<Eigen::Index>(measured.size()));
    for (std::size_t i = 0; i < measured.size(); ++i) r[static_cast<Eigen::Index>(i)] = whole[place[i]] - measured[i];
    return r.allFinite() ? std::optional(std::move(r)) : std::nullopt;
  }
  /// Residuals and their derivatives by x; central differences of so much of the scale, one-sided at bounds.
  struct Linear {
    Eigen::VectorXd residual;
    Eigen::MatrixXd jacobian;
  };
  std::optional<Linear> linear(std::span<const double> at, double difference = kDifference) {
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
  /// Of the weighted cost by x: J'r weight^2 and the priors' part.
  Eigen::VectorXd gradient(const Linear& linear) const {
    Eigen::VectorXd g = weight * weight * linear.jacobian.transpose() * linear.residual;
    for (std::size_t i = 0; i < x.size(); ++i)
      if (prior[i]) {
        const auto [mean, sd] = *prior[i];
        g[static_cast<Eigen::Index>(i)] += (scale[i] * x[i] - mean) / sd * scale[i] / sd;
      }
    return g;
  }
};

struct SeriesMinimum {
  bool converged = false;
  int iterations = 0;
};

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

/// Minimises from x, and leaves the minimum there. Variables that end at a bound are held there while the others come
/// to their minimum.
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
    if (std::ranges::all_of(held, [](bool one) { return one; }))
      minimum.converged = true;
    else if (changed || !minimum.converged)
      continue;
    break;
  }
  return minimum;
}

// Residuals of a fitted series as a first-order autoregressive series.
//   E r r' = sigma^2 Q R Q,  R_ij = phi^|i - j|,  Q = 1 - J (J'J)^-1 J'
// A fit of p parameters takes away much more than p / n of correlated noise: phi and sigma are those at which the
// expected sums of r_i^2 and of r_i r_(i+1) are the observed ones.

struct SeriesNoise {
  double phi = 0.0, variance = 0.0;
  double degrees = 0.0;   ///< sum of r^2 over the variance
  Eigen::MatrixXd joint;  ///< J' R J
};

using Eigen::Index;
using Eigen::MatrixXd;

constexpr double kLargestPhi = 0.999;

/// R m for R_ij = phi^|place_i - place_j|, by the recursion from both ends.
MatrixXd correlated(double phi, const std::vector<std::size_t>& place, const MatrixXd& m) {
  const Index n = m.rows();
  MatrixXd before = m, after = m;
  for (Index i = 1; i < n; ++i) {
    const auto at = static_cast<std::size_t>(i);
    before.row(i) += std::pow(phi, static_cast<double>(place[at] - place[at - 1])) * before.row(i - 1);
  }
  for (Index i = n - 2; i >= 0; --i) {
    const auto at = static_cast<std::size_t>(i);
    after.row(i) += std::pow(phi, static_cast<double>(place[at + 1] - place[at])) * after.row(i + 1);
  }
  return before + after - m;
}

struct Expected {
  double squares, neighbours;
};

/// Traces of Q R Q along its diagonal and beside it. `basis`: orthonormal columns that span J.
Expected expected_sums(double phi, const std::vector<std::size_t>& place, const MatrixXd& basis) {
  const MatrixXd seen = correlated(phi, place, basis), inner = basis.transpose() * seen;
  const auto entry = [&](Index i, Index j, double r) {
    return r - basis.row(i).dot(seen.row(j)) - seen.row(i).dot(basis.row(j)) + (basis.row(i) * inner).dot(basis.row(j));
  };
  Expected sums{0.0, 0.0};
  for (Index i = 0; i < basis.rows(); ++i) {
    sums.squares += entry(i, i, 1.0);
    const auto at = static_cast<std::size_t>(i);
    if (at + 1 < place.size() && place[at + 1] == place[at] + 1) sums.neighbours += entry(i, i + 1, phi);
  }
  return sums;
}

/// `place`: of each residual in the series, rising; rows of `jacobian` belong to the residuals.
SeriesNoise series_noise(const MatrixXd& jacobian, const Eigen::VectorXd& residual,
                         const std::vector<std::size_t>& place) {
  const MatrixXd basis = orthonormal_basis(jacobian);
  double squares = 0.0, neighbours = 0.0;
  for (Index i = 0; i < residual.size(); ++i) {
    squares += residual[i] * residual[i];
    const auto at = static_cast<std::size_t>(i);
    if (at + 1 < place.size() && place[at + 1] == place[at] + 1) neighbours += residual[i] * residual[i + 1];
  }
  const double observed = squares > 0.0 ? neighbours / squares : 0.0;
  const auto excess = [&](double phi) {
    const Expected e = expected_sums(phi, place, basis);
    return e.neighbours / e.squares - observed;
  };
  SeriesNoise noise;
  if (excess(kLargestPhi) <= 0.0) {
    noise.phi = kLargestPhi;
  } else if (excess(0.0) < 0.0) {
    double lo = 0.0, hi = kLargestPhi;
    for (int step = 0; step < 40; ++step) {
      const double middle = 0.5 * (lo + hi);
      (excess(middle) < 0.0 ? lo : hi) = middle;
    }
    noise.phi = 0.5 * (lo + hi);
  }
  noise.degrees = std::max(expected_sums(noise.phi, place, basis).squares, 1e-9);
  noise.variance = squares / noise.degrees;
  noise.joint = jacobian.transpose() * correlated(noise.phi, place, jacobian);
  return noise;
}

constexpr double kOnBound = 1e-6;  ///< of x

double lower(const SeriesParameter& p) { return std::max(p.lo, p.parameter.min.value_or(p.lo)); }
double upper(const SeriesParameter& p) { return std::min(p.hi, p.parameter.max.value_or(p.hi)); }

SeriesProblem problem_of(const Series& series, std::span<const SeriesParameter> parameters, const SeriesModel& model,
                         const SeriesFitOptions& options) {
  SeriesProblem problem;
  for (std::size_t i = 0; i < series.measured.size(); ++i) {
    if (!std::isfinite(series.measured[i])) continue;
    problem.measured.push_back(series.measured[i]);
    problem.place.push_back(i);
  }
  if (parameters.empty()) throw mtf::UsageError("fit: no number is marked with fit = true");
  if (problem.measured.size() <= parameters.size())
    throw mtf::UsageError("fit: " + std::to_string(problem.measured.size()) + " measured values do not determine " +
                          std::to_string(parameters.size()) + " numbers");
  for (const SeriesParameter& p : parameters) {
    const double lo = lower(p), hi = upper(p);
    if (!(lo < hi) || !(p.start >= lo && p.start <= hi))
      throw mtf::UsageError("fit: " + p.parameter.name + ": the start " + mtf::format_double(p.start) +
                            " has to be within its bounds " + mtf::format_double(lo) + " ... " +
                            mtf::format_double(hi) + ", which have to differ");
    double scale = p.scale > 0.0 ? p.scale : std::abs(p.start);
    if (!(scale > 0.0)) scale = std::isfinite(hi - lo) ? 0.1 * (hi - lo) : 1.0;
    problem.scale.push_back(scale);
    problem.lo.push_back(lo / scale);
    problem.hi.push_back(hi / scale);
    problem.x.push_back(p.start / scale);
    problem.prior.push_back(p.parameter.prior);
  }
  problem.model = &model;
  problem.options = options;
  problem.weight = 1.0 / series.sd.value_or(1.0);
  return problem;
}

SeriesResidual residual_of(const SeriesProblem& problem, std::span<const double> x) {
  SeriesResidual residual;
  residual.model = (*problem.model)(problem.values(x));
  if (residual.model.empty()) return residual;
  for (std::size_t i = 0; i < problem.measured.size(); ++i) {
    const double r = std::abs(residual.model[problem.place[i]] - problem.measured[i]);
    residual.rms += r * r / static_cast<double>(problem.measured.size());
    residual.worst = std::max(residual.worst, r);
  }
  residual.rms = std::sqrt(residual.rms);
  return residual;
}

/// What the errors are made of, at the solution.
struct Judged {
  SeriesProblem::Linear linear;
  SeriesNoise noise;
  double variance = 0.0;
  Identified identified;
  std::vector<double> ratio;  ///< of the variance to that of independent residuals
  Eigen::VectorXd gradient;
};

/// Against which an error of x counts as large (identifiability.h): a size by itself, others by their scale, at most
/// what is allowed.
double reference_of(const SeriesParameter& p, double x, double lo, double hi) {
  const double reference = p.scale > 0.0 ? 1.0 : std::max(std::abs(x), 1e-3);
  return p.parameter.min || p.parameter.max ? std::min(reference, hi - lo) : reference;
}

/// J'J less what its derivatives do not resolve: those of twice the difference differ by D = the error of the model
/// and of the differences. Along each eigenvector v of J'J, |D v|^2 is taken from |J v|^2; so a model that is exactly
/// degenerate, and solved to a tolerance, is seen to be.
Eigen::MatrixXd resolved_information(const Eigen::MatrixXd& j, const Eigen::MatrixXd& wide) {
  const Eigen::MatrixXd difference = wide - j;
  auto [values, vectors] = eigenpairs(j.transpose() * j);
  const double least = 1e-14 * std::max(values.maxCoeff(), 1e-300);
  for (Eigen::Index i = 0; i < values.size(); ++i)
    values[i] = std::max(values[i] - (difference * vectors.col(i)).squaredNorm(), least);
  return vectors * values.asDiagonal() * vectors.transpose();
}

std::optional<Judged> judge(SeriesProblem& problem, const Series& series, std::span<const SeriesParameter> parameters) {
  auto linear = problem.linear(problem.x);
  const auto wide = problem.linear(problem.x, 2.0 * kDifference);
  if (!linear || !wide) return std::nullopt;
  Judged judged{std::move(*linear), {}, 0.0, {}, {}, {}};
  judged.noise = series_noise(judged.linear.jacobian, judged.linear.residual, problem.place);
  const double stated = series.sd ? *series.sd * *series.sd : judged.noise.variance;
  judged.variance = stated * (series.sd ? trusted_noise(judged.noise.variance / stated) : 1.0);
  judged.variance = std::max(judged.variance, 1e-300);
  const Eigen::MatrixXd& j = judged.linear.jacobian;
  Eigen::MatrixXd priors = Eigen::MatrixXd::Zero(j.cols(), j.cols());
  for (Eigen::Index i = 0; i < j.cols(); ++i)
    if (const auto& prior = problem.prior[static_cast<std::size_t>(i)]) {
      const double weight = problem.scale[static_cast<std::size_t>(i)] / (*prior)[1];
      priors(i, i) = weight * weight;
    }
  const Eigen::MatrixXd independent = resolved_information(j, wide->jacobian) / judged.variance + priors;
  const Eigen::MatrixXd scores = judged.noise.joint / judged.variance + priors;
  std::vector<double> reference;
  for (std::size_t i = 0; i < parameters.size(); ++i)
    reference.push_back(reference_of(parameters[i], problem.x[i], problem.lo[i], problem.hi[i]));
  judged.identified = identify(sandwich_information(independent, scores), reference);
  const Eigen::MatrixXd least = identify(independent, reference).covariance;
  for (Eigen::Index i = 0; i < j.cols(); ++i)
    judged.ratio.push_back(std::max(1.0, judged.identified.covariance(i, i) / least(i, i)));
  problem.weight = 1.0 / std::sqrt(judged.variance);
  judged.gradient = problem.gradient(judged.linear);
  return judged;
}

std::vector<FittedParameter> parameters_of(const SeriesProblem& problem, const Judged& judged,
                                           std::span<const SeriesParameter> parameters) {
  std::vector<FittedParameter> all;
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    const auto index = static_cast<Eigen::Index>(i);
    FittedParameter p{.parameter = parameters[i].parameter, .start = parameters[i].start};
    set_knowledge(p, {.step = problem.scale[i], .lo = problem.lo[i], .hi = problem.hi[i]}, problem.x[i],
                  std::sqrt(judged.identified.covariance(index, index)), judged.identified.determined[i],
                  problem.prior[i], judged.gradient[index] / judged.ratio[i]);
    all.push_back(std::move(p));
  }
  return all;
}

/// The verdict needs a noise that somebody has stated.
void decide(const Series& series, SeriesFit& fit) {
  fit.status = FitStatus::converged;
  if (!series.sd) return;
  const double spread = 5.0 * std::sqrt(2.0 / std::max(1.0, static_cast<double>(fit.count)));
  const double structure = 5.0 / std::sqrt(static_cast<double>(fit.count));
  if (fit.chi2_per_dof <= 1.0 + spread && fit.phi <= structure) return;
  fit.status = FitStatus::converged_model_wrong;
  fit.reason = "the residuals are not those of independent values with the stated standard deviation of " +
               mtf::significant(*series.sd, 3) + ": they scatter by " + mtf::significant(fit.sd, 3) +
               ", and neighbours are correlated by " + mtf::significant(fit.phi, 3);
}

}  // namespace

SeriesFit fit_series(const Series& series, std::span<const SeriesParameter> parameters, const SeriesModel& model,
                     const SeriesFitOptions& options) {
  SeriesProblem problem = problem_of(series, parameters, model, options);
  SeriesFit fit;
  fit.count = problem.measured.size();
  fit.before = residual_of(problem, problem.x);
  if (fit.before.model.empty()) throw mtf::UsageError("fit: the model cannot be solved at the starting values");
  std::optional<Judged> judged;
  // A prior counts against what the data know, which correlated residuals lessen.
  const bool priors = std::ranges::any_of(problem.prior, [](const auto& p) { return p.has_value(); });
  for (int round = 0; round < (priors ? 3 : 1); ++round) {
    if (round > 0) problem.weight *= std::sqrt((1.0 - judged->noise.phi) / (1.0 + judged->noise.phi));
    const SeriesMinimum minimum = minimise(problem);
    fit.iterations += minimum.iterations;
    judged = judge(problem, series, parameters);
    if (minimum.converged && judged) continue;
    fit.status = FitStatus::not_converged;
    fit.reason = "the least squares did not converge; narrow the bounds, or start nearer";
    fit.evaluations = problem.evaluations;
    return fit;
  }
  fit.after = residual_of(problem, problem.x);
  fit.evaluations = problem.evaluations + 2;
  fit.sd = std::sqrt(judged->noise.variance);
  fit.phi = judged->noise.phi;
  fit.independent_values = static_cast<double>(fit.count) * (1.0 - fit.phi) / (1.0 + fit.phi);
  fit.chi2_per_dof = series.sd ? judged->noise.variance / (*series.sd * *series.sd) : 1.0;
  fit.parameters = parameters_of(problem, *judged, parameters);
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    const FittedParameter& p = fit.parameters[i];
    const double room = std::min(problem.x[i] - problem.lo[i], problem.hi[i] - problem.x[i]);
    if (p.knowledge == Knowledge::not_determined && room < kOnBound * std::max(1.0, std::abs(problem.x[i])))
      fit.warnings.push_back(p.parameter.name + " ran to its bound of " + mtf::significant(p.value, 6) +
                             (p.parameter.unit.empty() ? "" : " " + p.parameter.unit) +
                             ", and what it does is not separable from what others do");
  }
  fit.correlation = correlations_of(judged->identified.covariance);
  for (const WeakDirection& weak : judged->identified.weak) {
    std::vector<std::string> names;
    for (const std::size_t i : weak.members) names.push_back(parameters[i].parameter.name);
    fit.not_separable.push_back({weak.members, weak.weight, weak_direction_text(names, {.from = "this series"})});
  }
  decide(series, fit);
  return fit;
}

}  // namespace calib
