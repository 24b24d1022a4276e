// SPDX-License-Identifier: Apache-2.0
#pragma once

// MTF against frequency as lens programs list it, a block a field, with the tangential (modulation away from the axis,
// towards the field point) and the sagittal cut (across it). What is read is a line of column names and the numbers
// below:
//   OpticStudio   Spatial frequency units are cycles per mm.   Field: 0.0000, 14.0000 (deg)
//                 Spatial frequency     Tangential     Sagittal
//   CODE V        FIELD (X,Y)=( 0.00, 1.00)MAX, ( 0.00, 20.00)DEG      FOCUS POSITION
//                                                    Formula  Actual      -0.05000    0.00000
//                 L/MM f/4.500 RAD  TAN    RAD  TAN   RAD  TAN
//   tables        frequency (cy/mm), tangential, sagittal
//                 x (deg), y (deg), tangential (10 cy/mm), sagittal (10 cy/mm), ...   a row a place, against field
// RAD is the MTF of lines along the radius: the sagittal cut. Of several focus positions that of 0 is taken. An MTF has
// no phase, and its cuts are no surface: both are said.

#include "mtf/io/designs/design_text.h"

namespace mtf::io {

struct MtfField {
  std::optional<DesignField> place{};  ///< y down
  std::vector<double> frequency{}, tangential{}, sagittal{};
};

struct MtfListing {
  std::string unit{};  ///< "cy/mm" or "cy/mrad"
  std::vector<MtfField> fields{};
  DesignRemarks remarks{};
};

bool is_mtf_listing(const DesignText& text);

/// Throws UsageError "file:line: ..." for what is missing or no finite number.
MtfListing read_mtf_listing(const DesignText& text, const DesignReading& reading);

}  // namespace mtf::io
