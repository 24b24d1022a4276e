// SPDX-License-Identifier: Apache-2.0
#pragma once

// A search without derivatives, for objectives and constraints with kinks, by NLopt: COBYLA (Powell 1994), which knows
// constraints, and Subplex (Rowan 1990) in turns, each started again where the other has ended with smaller and smaller
// first steps; before them, where asked for, the evolution strategy ISRES (Runarsson and Yao, IEEE Trans. SMC C 35,
// 2005) over the whole box. Random numbers come from the seed alone.

#include "apps/study/optimum/smooth_search.h"

namespace study {

struct FreeTask : SearchTask {
  bool whole_box = false;
  std::uint64_t seed = 0;
};

/// The best design met: one that is feasible before all others, then the least F; else the least violation.
SearchEnd free_search(DesignProblem& problem, const ProblemScale& scale, std::vector<double> z, const FreeTask& task);

}  // namespace study
