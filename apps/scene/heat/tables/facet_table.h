// SPDX-License-Identifier: Apache-2.0
#pragma once

// Temperatures of single facets from elsewhere, in place of solving them: what another program, or an earlier run,
// computed.
//   temperatures.npy  '<f4' or '<f8': facets of the scene, or output times x facets as `mtf heat` writes them, with
//                     times.csv beside it for the times; straight lines between them, held beyond
//   temperatures.csv  facet,temperature_K: for all time
// Facets are numbered as in facets.csv.

#include <cstdint>
#include <string>
#include <vector>

namespace apps::scene {

struct FacetTable {
  std::string source;
  std::vector<double> time_s;  ///< UTC; empty: for all time
  std::size_t facets = 0;      ///< of the scene
  std::vector<float> kelvin;   ///< [time * facets + facet]; NaN for a facet that a CSV leaves out

  double at(std::uint32_t facet, double utc_s) const;
  double mean(std::uint32_t facet) const;
};

/// The instants (UTC, s) of the times.csv that `mtf heat` writes beside tables of that many rows. Throws RuntimeError
/// where it cannot be read, UsageError with its name for another number of times, or times that do not rise.
std::vector<double> read_output_times(const std::string& file, std::uint64_t rows);

/// Throws RuntimeError where a file cannot be read, UsageError with its name for a table of another number of facets,
/// times that do not rise, and temperatures that are none.
FacetTable read_facet_table(const std::string& path, std::size_t facets);

}  // namespace apps::scene
