// SPDX-License-Identifier: Apache-2.0
#pragma once

// A batch solved to a tolerance: plan, start and run in one call, and what a plan is made from.
//
// A plan is found by trial: the facet whose absorbed flux changes most and its neighbours, 32 in all, are run with a
// first guess of grid and step tolerance; what the promise of that run says decides the next guess. The tolerance is
// shared out: 0.45 to the time steps, 0.4 to the grid, 0.1 to the depth, 0.05 to a start that repeats.

#include <variant>

#include "radiometry/heat/periodic.h"
#include "radiometry/heat/solver.h"

namespace radiometry::heat {

/// All nodes of all facets at one temperature.
struct UniformStart {
  double temperature_k = 0.0;
};
/// The state that repeats when the first `period_s` of the run repeat. The breaks of the timeline have to go on to the
/// end of the period where the run is shorter.
struct RepeatingStart {
  double period_s = 86400.0;
};
using Start = std::variant<UniformStart, RepeatingStart>;

/// Throws UsageError for a batch that is not valid or a tolerance that is not above 0, and RuntimeError when the
/// tolerance cannot be kept with the finest grid or the shortest step.
Plan make_plan(const Batch& batch, const Forcing& forcing, const Timeline& timeline, const Start& start,
               double tolerance_k);
Plan make_plan(const Batch& batch, const GroupForcing& forcing, const Timeline& timeline, const Start& start,
               double tolerance_k);

struct Solution {
  Plan plan;
  Run run;  ///< run.promised.total_k() <= the tolerance
};

/// make_plan, the start and advance; where a facet beyond those of the trial breaks the tolerance, all of it again with
/// a finer plan.
Solution solve(const Batch& batch, const Forcing& forcing, const Timeline& timeline, const Start& start,
               double tolerance_k, int threads = 1);
Solution solve(const Batch& batch, const GroupForcing& forcing, const Timeline& timeline, const Start& start,
               double tolerance_k, int threads = 1);

}  // namespace radiometry::heat
