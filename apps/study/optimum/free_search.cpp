// SPDX-License-Identifier: Apache-2.0
#include "apps/study/optimum/free_search.h"

#include <nlopt.h>

#include <algorithm>
#include <cmath>
#include <memory>

namespace study {
namespace {

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

  void run(nlopt_algorithm algorithm, double step, int evaluations, std::vector<double> z);

 private:
  DesignProblem* problem_;
  const ProblemScale* scale_;
  const FreeTask* task_;
  int last_;
  std::vector<double> here_, best_;
  DesignPoint point_;
  double least_ = HUGE_VAL;
  bool best_feasible_ = false;
};

double objective_of(unsigned n, const double* z, double*, void* walker) {
  auto& w = *static_cast<Walker*>(walker);
  return w.objective(w.evaluate({z, n}));
}
double walled_of(unsigned n, const double* z, double*, void* walker) {
  auto& w = *static_cast<Walker*>(walker);
  return w.walled(w.evaluate({z, n}));
}
void violations_of(unsigned m, double* values, unsigned n, const double* z, double*, void* walker) {
  auto& w = *static_cast<Walker*>(walker);
  w.violations(w.evaluate({z, n}), {values, m});
}

void Walker::run(nlopt_algorithm algorithm, double step, int evaluations, std::vector<double> z) {
  const auto n = static_cast<unsigned>(z.size());
  const std::unique_ptr<nlopt_opt_s, void (*)(nlopt_opt)> owner(nlopt_create(algorithm, n), nlopt_destroy);
  nlopt_opt opt = owner.get();
  nlopt_set_lower_bounds1(opt, 0.0);
  nlopt_set_upper_bounds1(opt, 1.0);
  const bool wall = algorithm == NLOPT_LN_SBPLX;
  nlopt_set_min_objective(opt, wall ? walled_of : objective_of, this);
  if (!wall && !task_->only_constraints && problem_->constraints() > 0)
    nlopt_add_inequality_mconstraint(opt, static_cast<unsigned>(problem_->constraints()), violations_of, this, nullptr);
  nlopt_set_initial_step1(opt, step);
  nlopt_set_xtol_abs1(opt, 1e-11);
  nlopt_set_maxeval(opt, std::min(evaluations, left()));
  double value = 0.0;
  // What it says about its end does not matter: the best point met is kept here.
  static_cast<void>(nlopt_optimize(opt, z.data(), &value));
}

}  // namespace

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

}  // namespace study
