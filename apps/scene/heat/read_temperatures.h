// SPDX-License-Identifier: Apache-2.0
#pragma once

// Temperatures of facets (temperature_rows.h) from files:
//   a folder   that `mtf heat` wrote: temperatures.npy, with temperatures_back.npy for sheets, at the times of
//   times.csv
//   *.npy      '<f4' or '<f8': one row of facets, for all time; or output times x facets, with times.csv beside it
//   others     CSV with the columns facet,temperature_K, for all time
// Facets are numbered as in facets.csv.

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "radiometry/thermal/temperature_rows.h"

namespace apps::scene {

/// Of the values of a folder or an NPY file only the two rows about a time, or those nearest to it, where one is named:
/// a run may be longer than what memory holds. Doubles are rounded to float32, by 1.3e-4 K at most up to the 3000 K
/// that surfaces may have, 1.6e-5 K below 512 K. Throws RuntimeError where a file cannot be read, UsageError with its
/// name for another number of facets, times that do not rise, and temperatures that no surface has.
radiometry::thermal::TemperatureRows read_temperatures(const std::string& path, std::size_t facets,
                                                       std::optional<double> about_utc_s = std::nullopt);

/// The files that it reads; none for "".
std::vector<std::string> temperature_files(const std::string& path);

}  // namespace apps::scene
