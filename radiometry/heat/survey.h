// SPDX-License-Identifier: Apache-2.0
#pragma once

// What a plan has to know of the forcing before anything is solved, from samples of it.

#include <cstddef>
#include <vector>

#include "radiometry/heat/forcing.h"

namespace radiometry::heat {

struct Survey {
  std::vector<double> lowest_w_m2, highest_w_m2;  ///< per facet: absorbed flux of both sides
  double coldest_k = 0.0, hottest_k = 0.0;        ///< no facet leaves this range, nor that of its start
  double flux_w_m2 = 0.0;                         ///< no net flux into a surface is larger
  double shortest_lag_s = 0.0;                    ///< from a break (or the start) to the next output
};

/// Samples the forcing at the stops, on both sides, and between. With balances linear in time between the samples a
/// surface stays within the range of the temperatures at which it would be in balance with each of them and that of its
/// start, `start_k` (NaN: none, as for a start that repeats).
Survey survey(const Batch& batch, const GroupForcing& forcing, const Timeline& timeline, double start_k);

/// Of the batch in blocks of `block` neighbours: the first facet of the one with the facet whose flux changes most.
std::size_t block_to_try(const Survey& survey, std::size_t block);

}  // namespace radiometry::heat
