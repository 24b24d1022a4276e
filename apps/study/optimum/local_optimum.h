// SPDX-License-Identifier: Apache-2.0
#pragma once

// One local search of an optimisation, from its starting point to its end.

#include "apps/study/optimum/optimize.h"

namespace study {

/// A combination of levels, with the starting points of its searches.
struct Combination {
  std::vector<int> levels;
  std::vector<std::vector<double>> starts;  ///< points of the cube that can be worked out
  ProblemScale scale;
  std::string problem;  ///< why there are no starts
  int evaluations = 0;
};

Combination prepare_combination(const std::shared_ptr<const Study>& sharp, const Goal& goal, std::vector<int> levels,
                                int starts);

struct LocalEnd {
  Optimum optimum;
  std::vector<double> z;
  double violation = 0.0;                  ///< root of the sum of squares of the scaled ones
  std::vector<std::string> contradiction;  ///< what contradicts, where the end is not feasible
  int evaluations = 0;
};

LocalEnd local_optimum(const std::shared_ptr<const Study>& sharp, const Goal& goal, const Combination& combination,
                       std::size_t start, OptimizeOptions::Method method);

}  // namespace study
