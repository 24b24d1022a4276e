// SPDX-License-Identifier: Apache-2.0
#include "apps/study/optimum/local_optimum.h"

#include <nlopt.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "apps/study/optimum/design_problem.h"
#include "apps/study/optimum/smooth_search.h"
#include "calib/dense.h"

namespace study {
namespace {

// Whether a design is an optimum, and which limits make it one: the slope of F has to be a sum of slopes of active
// limits, with multipliers >= 0 (Karush, Kuhn and Tucker). The multipliers are those of least squares (Lawson and
// Hanson, Solving Least Squares Problems, chapter 23), and each is what F would gain by its limit being relaxed.

/// A limit is active when the design is as close to it as this, relative.
inline constexpr double kReached = 1e-6;

/// An active limit: a constraint, or an end of an axis.
struct ReachedLimit {
  Limit::Kind kind = Limit::Kind::constraint;
  std::size_t index = 0;    ///< index of the constraint, or of the variable
  double multiplier = 0.0;  ///< derivative of scaled F by the scaled margin, or by z
  double gain = 0.0;        ///< decrease of F by a margin wider by one (SI), or an axis longer by one of its unit
};

struct Optimality {
  std::vector<ReachedLimit> limits;  ///< within 1e-6 of the limit, or of the axis
  bool smooth = false;               ///< the design has slopes; else no multipliers and no residual
  bool shared = false;               ///< slopes of limits depend on each other: the multipliers are one choice of many
  double residual = 0.0;             ///< largest part, by axis, of the slope of F / ProblemScale::f that nothing holds
  std::vector<double> downhill;      ///< minus that slope
};

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// x >= 0 with the least |A x - b|.
VectorXd non_negative(const MatrixXd& a, const VectorXd& b) {
  const Index m = a.cols();
  VectorXd x = VectorXd::Zero(m);
  std::vector<bool> free(static_cast<std::size_t>(m), false);
  const auto solve = [&] {
    std::vector<Index> columns;
    for (Index k = 0; k < m; ++k)
      if (free[static_cast<std::size_t>(k)]) columns.push_back(k);
    MatrixXd part(a.rows(), static_cast<Index>(columns.size()));
    for (std::size_t k = 0; k < columns.size(); ++k) part.col(static_cast<Index>(k)) = a.col(columns[k]);
    const VectorXd s = calib::least_squares(part, b);
    VectorXd whole = VectorXd::Zero(m);
    for (std::size_t k = 0; k < columns.size(); ++k) whole[columns[k]] = s[static_cast<Index>(k)];
    return whole;
  };
  const double small = 1e-13 * (1.0 + b.norm()) * (1.0 + a.norm());
  for (Index round = 0; round < 3 * m + 3; ++round) {
    const VectorXd pull = a.transpose() * (b - a * x);
    Index enter = -1;
    for (Index k = 0; k < m; ++k)
      if (!free[static_cast<std::size_t>(k)] && pull[k] > small && (enter < 0 || pull[k] > pull[enter])) enter = k;
    if (enter < 0) break;
    free[static_cast<std::size_t>(enter)] = true;
    for (Index inner = 0; inner <= m; ++inner) {
      const VectorXd s = solve();
      const auto falls = [&](Index k) { return free[static_cast<std::size_t>(k)] && s[k] <= 0.0; };
      double step = 1.0;
      for (Index k = 0; k < m; ++k)
        if (falls(k)) step = std::min(step, x[k] > 0.0 ? x[k] / (x[k] - s[k]) : 0.0);
      bool dropped = false;
      x += step * (s - x);
      for (Index k = 0; k < m; ++k)
        if (falls(k) && x[k] <= 1e-14 * (1.0 + x.norm())) {
          free[static_cast<std::size_t>(k)] = false;
          x[k] = 0.0;
          dropped = true;
        }
      if (!dropped) break;
    }
    x = x.cwiseMax(0.0);
  }
  return x;
}

void add_ends(std::span<const double> z, std::vector<ReachedLimit>& limits) {
  for (std::size_t i = 0; i < z.size(); ++i) {
    if (z[i] <= kReached) limits.push_back({Limit::Kind::lower, i});
    if (z[i] >= 1.0 - kReached) limits.push_back({Limit::Kind::upper, i});
  }
}

/// Multipliers of the limits for the slope `b`.
void hold(Optimality& result, const VectorXd& b, const DesignSlopes& slopes, const ProblemScale& scale) {
  const Index n = b.size();
  if (n == 0) return;
  MatrixXd a = MatrixXd::Zero(n, static_cast<Index>(result.limits.size()));
  for (std::size_t k = 0; k < result.limits.size(); ++k) {
    const ReachedLimit& limit = result.limits[k];
    const auto column = static_cast<Index>(k), index = static_cast<Index>(limit.index);
    if (limit.kind == Limit::Kind::constraint)
      for (Index i = 0; i < n; ++i)
        a(i, column) = slopes.margin[static_cast<std::size_t>(index * n + i)] / scale.margin[limit.index];
    else
      a(index, column) = limit.kind == Limit::Kind::lower ? 1.0 : -1.0;
  }
  const VectorXd multipliers = non_negative(a, b);
  VectorXd left = b;
  if (a.cols() > 0) {
    left -= a * multipliers;
    result.shared = calib::rank_of(a, 1e-9) < a.cols();
  }
  for (std::size_t k = 0; k < result.limits.size(); ++k)
    result.limits[k].multiplier = multipliers[static_cast<Index>(k)];
  result.residual = left.cwiseAbs().maxCoeff();
  for (const double slope : left) result.downhill.push_back(-slope);
}

Optimality optimality_at(DesignProblem& problem, const ProblemScale& scale, std::span<const double> z) {
  Optimality result;
  const DesignPoint point = problem.at(z);
  for (std::size_t j = 0; j < point.margin.size(); ++j) {
    const ConstraintValues& sides = problem.sides()[j];
    const double size = std::max({std::abs(sides.left), std::abs(sides.right), 1e-3 * scale.margin[j]});
    if (std::abs(point.margin[j]) <= kReached * size) result.limits.push_back({Limit::Kind::constraint, j});
  }
  add_ends(z, result.limits);
  const DesignSlopes slopes = problem.slopes(z);
  bool finite = std::all_of(slopes.f.begin(), slopes.f.end(), [](double v) { return std::isfinite(v); });
  for (const ReachedLimit& limit : result.limits)
    for (std::size_t i = 0; limit.kind == Limit::Kind::constraint && i < z.size(); ++i)
      finite = finite && std::isfinite(slopes.margin[limit.index * z.size() + i]);
  if (!finite) return result;
  result.smooth = true;
  hold(result, Eigen::Map<const VectorXd>(slopes.f.data(), static_cast<Index>(z.size())) / scale.f, slopes, scale);
  for (ReachedLimit& limit : result.limits)
    limit.gain = limit.multiplier * scale.f /
                 (limit.kind == Limit::Kind::constraint ? scale.margin[limit.index]
                                                        : problem.stretch(limit.index, z[limit.index]));
  return result;
}

/// For a design that misses constraints: which limits of the box prevent smaller violations, and what
/// is left of the slope of half the sum of their squares.
Optimality nearness_at(DesignProblem& problem, const ProblemScale& scale, std::span<const double> z) {
  Optimality result;
  const DesignPoint point = problem.at(z);
  const DesignSlopes slopes = problem.slopes(z);
  add_ends(z, result.limits);
  const auto n = static_cast<Index>(z.size());
  VectorXd slope = VectorXd::Zero(n);
  for (std::size_t j = 0; j < point.margin.size(); ++j) {
    const double short_of = -point.margin[j] / scale.margin[j];
    if (!(short_of > 0.0)) continue;
    for (Index i = 0; i < n; ++i)
      slope[i] -=
          short_of * slopes.margin[j * static_cast<std::size_t>(n) + static_cast<std::size_t>(i)] / scale.margin[j];
  }
  if (!slope.allFinite()) return result;
  result.smooth = true;
  hold(result, slope, slopes, scale);
  return result;
}

// A search without derivatives, for objectives and constraints with kinks, by NLopt: COBYLA (Powell 1994), which knows
// constraints, and Subplex (Rowan 1990) in turns, each started again where the other has ended with smaller and smaller
// first steps; before them, where asked for, the evolution strategy ISRES (Runarsson and Yao, IEEE Trans. SMC C 35,
// 2005) over the whole box. Random numbers come from the seed alone.

struct FreeTask : SearchTask {
  bool whole_box = false;
  std::uint64_t seed = 0;
};

constexpr double kImpossible = 1e3;  // as value of a design that cannot be: seen values stay below 710

class Walker {
 public:
  Walker(DesignProblem& problem, const ProblemScale& scale, const FreeTask& task)
      : problem_(&problem), scale_(&scale), task_(&task), last_(problem.evaluations() + task.most_evaluations) {}

  bool spent() const { return problem_->evaluations() >= last_; }
  int left() const { return std::max(1, last_ - problem_->evaluations()); }
  const std::vector<double>& best() const { return best_; }
  double least() const { return least_; }
  bool found_feasible() const { return best_feasible_; }

  const DesignPoint& evaluate(std::span<const double> z) {
    if (std::equal(z.begin(), z.end(), here_.begin(), here_.end()) && !here_.empty()) return point_;
    here_.assign(z.begin(), z.end());
    point_ = problem_->at(z);
    const bool feasible = !task_->only_constraints && problem_->feasible(point_);
    const double rank = feasible ? point_.f : total_violation(point_, *scale_);
    if (best_.empty() || (feasible && !best_feasible_) || (feasible == best_feasible_ && rank < least_)) {
      best_ = here_;
      best_feasible_ = feasible;
      least_ = rank;
    }
    return point_;
  }

  double objective(const DesignPoint& point) const {
    if (task_->only_constraints) {
      const double total = total_violation(point, *scale_);
      return std::isfinite(total) ? std::asinh(total) : kImpossible;
    }
    const double compressed = compressed_objective(point, *scale_);
    return std::isfinite(compressed) ? compressed : kImpossible;
  }
  void violations(const DesignPoint& point, std::span<double> values) const {
    for (std::size_t j = 0; j < values.size(); ++j) {
      const double compressed = compressed_violation(point, *scale_, j);
      values[j] = std::isfinite(compressed) ? compressed : point.margin[j] > 0.0 ? -kImpossible : 1.0;
    }
  }
  /// Objective where all constraints hold, far above it elsewhere.
  double walled(const DesignPoint& point) const {
    if (task_->only_constraints || problem_->feasible(point)) return objective(point);
    const double total = total_violation(point, *scale_);
    return kImpossible + (std::isfinite(total) ? std::asinh(total) : kImpossible);
  }

  void run(nlopt_algorithm algorithm, double step, int evaluations, std::vector<double> z) {
    const auto n = static_cast<unsigned>(z.size());
    const std::unique_ptr<nlopt_opt_s, void (*)(nlopt_opt)> owner(nlopt_create(algorithm, n), nlopt_destroy);
    nlopt_opt opt = owner.get();
    nlopt_set_lower_bounds1(opt, 0.0);
    nlopt_set_upper_bounds1(opt, 1.0);
    const bool wall = algorithm == NLOPT_LN_SBPLX;
    nlopt_set_min_objective(opt, wall ? walled_of : objective_of, this);
    if (!wall && !task_->only_constraints && problem_->constraints() > 0)
      nlopt_add_inequality_mconstraint(opt, static_cast<unsigned>(problem_->constraints()), violations_of, this,
                                       nullptr);
    nlopt_set_initial_step1(opt, step);
    nlopt_set_xtol_abs1(opt, 1e-11);
    nlopt_set_maxeval(opt, std::min(evaluations, left()));
    double value = 0.0;
    // What it says about its end does not matter: the best point met is kept here.
    static_cast<void>(nlopt_optimize(opt, z.data(), &value));
  }

 private:
  static double objective_of(unsigned n, const double* z, double*, void* walker) {
    auto& w = *static_cast<Walker*>(walker);
    return w.objective(w.evaluate({z, n}));
  }
  static double walled_of(unsigned n, const double* z, double*, void* walker) {
    auto& w = *static_cast<Walker*>(walker);
    return w.walled(w.evaluate({z, n}));
  }
  static void violations_of(unsigned m, double* values, unsigned n, const double* z, double*, void* walker) {
    auto& w = *static_cast<Walker*>(walker);
    w.violations(w.evaluate({z, n}), {values, m});
  }

  DesignProblem* problem_;
  const ProblemScale* scale_;
  const FreeTask* task_;
  int last_;
  std::vector<double> here_, best_;
  DesignPoint point_;
  double least_ = HUGE_VAL;
  bool best_feasible_ = false;
};

/// The best design met: one that is feasible before all others, then the least F; else the least violation.
SearchEnd free_search(DesignProblem& problem, const ProblemScale& scale, std::vector<double> z, const FreeTask& task) {
  Walker walker(problem, scale, task);
  walker.evaluate(z);
  if (z.empty()) return {z};
  nlopt_srand(static_cast<unsigned long>(task.seed));  // of this thread
  const int n = static_cast<int>(z.size());
  if (task.whole_box) walker.run(NLOPT_GN_ISRES, 0.25, std::min(400 * (n + 1), task.most_evaluations / 2), z);
  for (const double first : {0.25, 0.05, 0.005}) {
    double before = HUGE_VAL;
    for (int round = 0; round < 8 && !walker.spent(); ++round) {
      const double step = first * std::pow(0.5, round);
      walker.run(NLOPT_LN_COBYLA, step, 150 * (n + 1), walker.best());
      walker.run(NLOPT_LN_SBPLX, step, 150 * (n + 1), walker.best());
      if (walker.found_feasible() && walker.least() > before - 1e-10 * scale.f) break;
      if (!walker.found_feasible() && round > 1 && walker.least() > 0.999 * before) break;
      before = walker.least();
    }
  }
  return {walker.best()};
}

using Method = OptimizeOptions::Method;
constexpr double kConverged = 1e-5;  // residual
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

/// One start: the searches, and the best that they have found.
class Start {
 public:
  Start(const std::shared_ptr<const Study>& sharp, const Goal& goal, const Combination& combination, std::size_t start)
      : problem_(sharp, goal, combination.levels),
        scale_(combination.scale),
        z_(combination.starts[start]),
        seed_(sharp->seed * 1000003U + start),
        whole_box_(start == 0) {
    take(z_);
  }

  LocalEnd run(Method method) {
    LocalEnd end;
    Optimum& optimum = end.optimum;
    optimum.method = method;
    if (method == Method::smooth && !z_.empty()) {
      smooth();
      if (feasible_ ? !converged() : !locally_nearest()) {
        const bool feasible = feasible_;
        const double before = rank_;
        search();
        if (feasible_ && !converged()) smooth();  // off a kink, perhaps to an optimum that is smooth
        if (rank_ < before || feasible_ != feasible) optimum.method = Method::search;
        optimum.why = no_slopes_  ? "the smooth method came to designs without derivatives"
                      : !feasible ? "the smooth method found no feasible design"
                                  : "the smooth method stalled short of an optimum";
      }
    } else if (!z_.empty()) {
      search();
    }
    snap();
    describe(end);
    if (optimum.method == method) optimum.why.clear();
    end.evaluations = problem_.evaluations();
    return end;
  }

 private:
  double rank(const DesignPoint& point, bool feasible) const {
    return feasible ? point.f : total_violation(point, scale_);
  }
  /// Keeps the better one.
  void take(const std::vector<double>& z) {
    const DesignPoint point = problem_.at(z);
    const bool feasible = problem_.feasible(point);
    if (!taken_ || (feasible && !feasible_) || (feasible == feasible_ && rank(point, feasible) < rank_)) {
      z_ = z;
      feasible_ = feasible;
      rank_ = rank(point, feasible);
      taken_ = true;
    }
  }
  void smooth() {
    const std::vector<double> first = z_;
    const auto walk = [&](const std::vector<double>& from, bool only_constraints) {
      const SearchEnd end = smooth_search(problem_, scale_, from, {.only_constraints = only_constraints});
      no_slopes_ = no_slopes_ || end.no_slopes;
      take(end.z);
    };
    walk(z_, false);
    if (!feasible_) {
      walk(z_, true);
      if (!feasible_) walk(first, true);
      if (feasible_) walk(z_, false);
    }
    // An end of the box holds a walk whose theta has come too close to it, whatever the slope there.
    for (int again = 0; again < 3 && feasible_ && !converged(); ++again) {
      snap();
      const Optimality optimality = optimality_at(problem_, scale_, z_);
      if (!optimality.smooth) return;
      std::vector<double> inside = z_;
      for (std::size_t i = 0; i < inside.size(); ++i)
        if ((inside[i] < 0.01 && optimality.downhill[i] > kConverged) ||
            (inside[i] > 0.99 && optimality.downhill[i] < -kConverged))
          inside[i] = inside[i] < 0.5 ? 0.05 : 0.95;
      const double before = rank_;
      walk(inside, false);
      if (!(rank_ < before)) return;
    }
  }
  void search() {
    FreeTask task;
    task.most_evaluations = 500 * (static_cast<int>(z_.size()) + 1);
    task.whole_box = whole_box_;
    task.seed = seed_;
    take(free_search(problem_, scale_, z_, task).z);
    if (feasible_) return;
    task.only_constraints = true;
    task.whole_box = false;
    take(free_search(problem_, scale_, z_, task).z);
  }
  /// By the slopes, no design nearby is nearer to feasible.
  bool locally_nearest() {
    const Optimality nearness = nearness_at(problem_, scale_, z_);
    return nearness.smooth && nearness.residual <= kConverged;
  }
  bool converged() {
    if (!feasible_) return false;
    const Optimality optimality = optimality_at(problem_, scale_, z_);
    return optimality.smooth && optimality.residual <= kConverged;
  }
  /// Onto the ends of axes that it has come to.
  void snap() {
    for (std::size_t i = 0; i < z_.size(); ++i) {
      const double end = std::round(z_[i]);
      if (z_[i] == end || std::abs(z_[i] - end) > kReached) continue;
      std::vector<double> snapped = z_;
      snapped[i] = end;
      const DesignPoint point = problem_.at(snapped);
      const bool feasible = problem_.feasible(point);
      const double rank = this->rank(point, feasible);
      if (feasible != feasible_ || !(rank <= rank_ + 1e-9 * (feasible ? scale_.f : 1.0))) continue;
      z_ = snapped;
      rank_ = rank;
    }
  }
  void describe(LocalEnd& end) {
    Optimum& optimum = end.optimum;
    const Study& study = problem_.study();
    const Optimality optimality = feasible_ ? optimality_at(problem_, scale_, z_) : nearness_at(problem_, scale_, z_);
    const DesignPoint point = problem_.at(z_);
    optimum.axis_values = problem_.axis_values(z_);
    optimum.row.assign(problem_.row().begin(), problem_.row().end());
    optimum.objectives.assign(problem_.objectives().begin(), problem_.objectives().end());
    optimum.goal = point.f;
    optimum.feasible = feasible_;
    optimum.residual = optimality.smooth ? optimality.residual : kNan;
    optimum.converged = feasible_ && optimum.residual <= kConverged;
    optimum.shared = optimality.shared;
    end.z = z_;
    end.violation = total_violation(point, scale_);
    const std::vector<ConstraintValues> sides(problem_.sides().begin(), problem_.sides().end());
    for (std::size_t j = 0; j < point.margin.size(); ++j) {
      if (point.margin[j] > 0.0 || (point.margin[j] == 0.0 && !study.constraints[j].strict)) continue;
      const std::string unit = unit_of(study, study.constraints[j]);
      optimum.violations.push_back(
          {j, -point.margin[j] / unit_scale(unit).si, -point.margin[j] / scale_.margin[j], unit});
      end.contradiction.push_back(study.constraints[j].text);
    }
    for (const ReachedLimit& reached : optimality.limits) {
      const bool constraint = reached.kind == Limit::Kind::constraint;
      std::size_t index = reached.index;
      if (!constraint) index = static_cast<std::size_t>(&problem_.axis(reached.index) - study.axes.data());
      Limit limit = limit_of(study, reached.kind, index, optimum.axis_values, sides);
      limit.gain = optimum.converged ? reached.gain * (constraint ? unit_scale(limit.unit).si : 1.0) : kNan;
      // Below the residual a multiplier is none.
      if (optimum.converged && reached.multiplier <= std::max(1e-9, 2.0 * optimality.residual)) limit.gain = 0.0;
      if (!feasible_ && reached.multiplier > 1e-9) end.contradiction.push_back(limit.text);
      optimum.limits.push_back(std::move(limit));
    }
    // A little further in that direction: is there a design at all?
    if (feasible_ && !optimum.converged && optimality.smooth) {
      std::vector<double> beyond = z_;
      for (std::size_t i = 0; i < z_.size(); ++i)
        beyond[i] = std::clamp(z_[i] + 1e-4 * optimality.downhill[i] / optimality.residual, 0.0, 1.0);
      if (!std::isfinite(problem_.at(beyond).f)) optimum.edge = problem_.problem();
    }
  }

  DesignProblem problem_;
  const ProblemScale& scale_;
  std::vector<double> z_;
  std::uint64_t seed_;
  bool whole_box_;
  bool taken_ = false, feasible_ = false, no_slopes_ = false;
  double rank_ = HUGE_VAL;
};

}  // namespace

Combination prepare_combination(const std::shared_ptr<const Study>& sharp, const Goal& goal, std::vector<int> levels,
                                int starts) {
  Combination combination;
  combination.levels = levels;
  DesignProblem problem(sharp, goal, std::move(levels));
  const std::size_t axes = sharp->axes.size();
  const std::vector<SobolAxis> directions = sobol_axes(axes);
  std::vector<double> unit(axes), values(axes);
  std::vector<std::vector<double>> points;
  // Where much of the box has no designs, the starts come from further on in the sequence.
  for (std::uint64_t i = 0; i < 64U * static_cast<std::uint64_t>(starts); ++i) {
    for (std::size_t a = 0; a < axes; ++a)
      unit[a] = sobol(directions[a], i, static_cast<std::uint32_t>(a), sharp->seed);
    design_at_quantiles(*sharp, unit, values);
    std::vector<double> z = problem.cube(values);
    const DesignPoint point = problem.at(z);
    if (!std::isfinite(point.f) || std::isinf(violation(point, {1.0, 0.0, std::vector(point.margin.size(), 1.0)}))) {
      if (combination.problem.empty()) combination.problem = problem.problem();
    } else {
      points.push_back(std::move(z));
    }
    if (problem.variables() == 0 || (points.size() >= static_cast<std::size_t>(starts) && i >= 31)) break;
  }
  combination.scale = scale_of(problem, points);
  points.resize(std::min(points.size(), static_cast<std::size_t>(starts)));
  combination.starts = std::move(points);
  combination.evaluations = problem.evaluations();
  return combination;
}

LocalEnd local_optimum(const std::shared_ptr<const Study>& sharp, const Goal& goal, const Combination& combination,
                       std::size_t start, OptimizeOptions::Method method) {
  return Start(sharp, goal, combination, start).run(method);
}

}  // namespace study
