// SPDX-License-Identifier: Apache-2.0
#pragma once

// Listings of any layout, by what their columns are: rows of numbers become a table that the readers of tables know.
// Columns are named as there, in the order of the listing:
//   x (deg), y (deg), Z1-Z8 (waves)  Z1 to Z8 stand for a column each
//   x (deg) = 0                     a number that is no column, the same for all rows
//   -                               a column that is left out
// Read are the lines that have as many numbers as there are columns, and nothing else.
//
// OpticStudio's Zernike coefficients against field name their columns "Field: 1 2 3 ...", Zernike Standard or Fringe
// terms in waves, places along +y, the scan that is preset; a scan along another direction is not told by the numbers.

#include "mtf/io/designs/design_text.h"

namespace mtf::io {

/// The columns of such a listing of OpticStudio, in the words above; "" of any other text. Throws UsageError where the
/// unit of its fields or its wavelength is missing.
std::string field_scan_columns(const DesignText& text);

/// The table, each row on the line where it stood, all other lines comments. Says which lines of numbers are left out.
/// Throws UsageError where no line has as many numbers.
DesignText with_columns(const DesignText& text, const std::string& columns, DesignRemarks& remarks);

}  // namespace mtf::io
