// SPDX-License-Identifier: Apache-2.0
#pragma once

// Tables of the temperatures of single facets (FacetTable) as files.
//   temperatures.npy  '<f4' or '<f8': facets of the scene, or output times x facets as `mtf heat` writes them, with
//                     times.csv beside it for the times; straight lines between them, held beyond
//   temperatures.csv  facet,temperature_K: for all time
// Facets are numbered as in facets.csv.

#include <cstdint>
#include <string>
#include <vector>

#include "apps/scene/heat/read_thermal_scene.h"

namespace apps::scene {

/// The instants (UTC, s) of the times.csv that `mtf heat` writes beside tables of that many rows. Throws RuntimeError
/// where it cannot be read, UsageError with its name for another number of times, or times that do not rise.
std::vector<double> read_output_times(const std::string& file, std::uint64_t rows);

/// Throws RuntimeError where a file cannot be read, UsageError with its name for a table of another number of facets,
/// times that do not rise, and temperatures that are none.
FacetTable read_facet_table(const std::string& path, std::size_t facets);

}  // namespace apps::scene
