// SPDX-License-Identifier: Apache-2.0
#pragma once

// MODTRAN's tape7 (.tp7, .fl7): transmission and radiance of a path against wavenumber. A file holds one or more runs:
//   about ten lines that repeat the input, without FREQ in them
//   a header with FREQ; two lines of it where only transmission is computed (IEMSCT = 0: COMBIN / TRANS)
//   one row a wavenumber (cm^-1), numbers right-aligned below their names; columns that do not apply are blank
//   -9999.
// Rows are read by position: a blank column would shift all that follow it if they were split at spaces. Names:
//   IEMSCT 0     COMBIN TRANS, the product of all gases
//   IEMSCT 1, 2  TOT TRANS; radiance of the path = PTH THRML + SOL SCAT (of which THRML SCT and SING SCAT are parts;
//                surface and ground terms are not of the path), W cm^-2 sr^-1 / cm^-1
//   IEMSCT 3     TRANS; sun and moon, no radiance of a path
// L per um = L per cm^-1 x 1e4 cm^2 m^-2 x k^2 / 1e4, k the wavenumber; order is reversed to rising wavelengths.

#include <string>
#include <string_view>
#include <vector>

#include "mtf/io/csv/spectrum_csv.h"

namespace mtf::io {

struct Tape7Run {
  std::string source;                 ///< "file:line" of its header
  std::vector<double> wavelength_um;  ///< strictly rising
  std::vector<double> transmission;   ///< 0 to 1
  std::vector<double> radiance;       ///< W m^-2 sr^-1 um^-1; empty where the run has none
};

/// All runs of a file, at most 256 MiB. Throws RuntimeError when it cannot be read, UsageError "file:line: ..." when it
/// is no tape7, cut short (no -9999. at the end), or holds what is no number.
std::vector<Tape7Run> read_tape7(const std::string& path);
std::vector<Tape7Run> parse_tape7(std::string_view text, const std::string& source);

/// Runs as a table of paths, one for each range in m, above 0 and rising. Throws UsageError for another number of
/// ranges, runs without radiance (both terms are needed) and runs at different wavelengths.
PathColumns path_columns(const std::vector<Tape7Run>& runs, const std::vector<double>& range_m);

}  // namespace mtf::io
