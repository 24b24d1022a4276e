// SPDX-License-Identifier: Apache-2.0
#pragma once

// A local optimum of a smooth problem: augmented Lagrangian of the inequalities (Rockafellar, Math. Programming 5,
// 1973; Nocedal and Wright, Numerical Optimization, chapter 17), each of its functions minimized by Ceres' BFGS with
// autodiff slopes. The box is kept by z = sin^2(theta / 2), so that nothing outside of it is ever worked out.

#include "apps/study/optimum/design_problem.h"

namespace study {

struct SearchTask {
  bool only_constraints = false;  ///< make the violations small, whatever the objective
  int most_evaluations = 2000;
};

/// Where a search has ended, which need not be an optimum: the caller checks.
struct SearchEnd {
  std::vector<double> z;
  bool no_slopes = false;  ///< it met a design that has values and no derivatives
};

/// `z`: start, at which F (unless only_constraints) and margins are numbers.
SearchEnd smooth_search(DesignProblem& problem, const ProblemScale& scale, std::vector<double> z,
                        const SearchTask& task);

/// F and violations for the searches: asinh of the scaled values, which changes neither optimum nor limits and
/// keeps large values from hiding small ones. violation <= 0 where the constraint holds.
double compressed_objective(const DesignPoint& point, const ProblemScale& scale);
double compressed_violation(const DesignPoint& point, const ProblemScale& scale, std::size_t constraint);

}  // namespace study
