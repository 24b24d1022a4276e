// SPDX-License-Identifier: Apache-2.0
#pragma once

// The heat balance of one facet by SUNDIALS CVODE (backward differences of variable order, banded analytic Jacobian),
// restarted at every break: the truth that the solver is compared with, and its rival in the benchmark. It shares the
// grid and the closures' coefficients with the solver, nothing else.

#include <cstdint>
#include <vector>

#include "radiometry/heat/solver.h"

namespace radiometry::heat::test {

struct OracleRun {
  std::vector<double> front_k, back_k;  ///< per output; back of sheets
  std::int64_t steps = 0;
};

/// Facet `facet` of the batch on a grid, from temperatures of its nodes.
OracleRun oracle(const Batch& batch, std::size_t facet, const Grid& grid, const Forcing& forcing,
                 const Timeline& timeline, std::vector<double> start_k, double relative, double absolute_k);

/// From a uniform temperature, on the grid of `density` and on that of half as many cells, extrapolated (Richardson).
OracleRun oracle_extrapolated(const Batch& batch, std::size_t facet, const GridRequest& request, const Forcing& forcing,
                              const Timeline& timeline, double start_k, double relative = 1e-10);

}  // namespace radiometry::heat::test
