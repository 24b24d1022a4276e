// SPDX-License-Identifier: Apache-2.0
#pragma once

// MTF curves as data to fit, with their standard deviations, from any CSV that the toolkit reads or writes:
//   frequency_cy_mm,mtf[,sd]        other instruments (mtf/io/csv/curve_csv.h); further columns are ignored
//   frequency,...,system            `mtf curve --format csv`: the system's column, or system_re and system_im; its
//                                   frequency has the unit of --unit, cycles/mm by default;
//                                   the file does not state it
//   edge,curve,x,value,sd[,x_unit]  `mtf measure --curves`: one curve an edge, the rows called mtf, in cycles/pixel or
//                                   the unit of their column x_unit: cy/px, cy/mm, lp/mm (the same) or cy/mrad
//   MTF Mapper's edge_sfr_values.txt  one of each edge, in cy/px; edges of all directions stand in it
//   sfrmat4 and 5, Imatest (_MTF.csv)  a table below other lines, of a frequency and SFR or MTF columns, one a colour:
//       Frequency, cy/pixel | SFR-r | SFR-g | SFR-b | Lum          Cy/mm | LW/PH | MTF | MTF(R) ...
//       what is called MTF or SFR is taken, else the luminance; cy/px where it is there; the column sd

#include <string>
#include <string_view>
#include <vector>

#include "mtf/component.h"

namespace mtf::io {

struct CurveSamples {
  std::string name;            ///< "edge 2"; "" where the file is one curve
  const Unit* unit = nullptr;  ///< cy/mm, cy/mrad or cy/px
  std::vector<double> frequency, mtf;
  std::vector<double> sd;  ///< of every sample, above 0; empty where the file has none
};

/// Samples without an error (f = 0 of a measured curve, where every MTF is 1) and cells without a number where an sd
/// belongs are left out. Errors as read_curve_csv; UsageError, too, where no curve is in the file.
/// `bare`: the unit of a column that is called frequency without a unit, in a file with a system's column.
std::vector<CurveSamples> parse_curve_samples(std::string_view text, const std::string& source,
                                              const Unit* bare = nullptr);

/// Whether a line of names has a frequency and an MTF.
bool is_curve_header(std::string_view line);

}  // namespace mtf::io
