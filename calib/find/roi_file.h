// SPDX-License-Identifier: Apache-2.0
#pragma once

// Regions as text: x,y,width,height in pixels from the image's upper left corner, and a name where one is wanted. A
// file has one a line; `#` starts a comment line, a first line without numbers is a header, separators are comma,
// semicolon or tab:
//   # lens 12, f/4
//   x,y,width,height,name
//   120,80,64,96,upper left
//   480,90,64,96

#include <string>
#include <string_view>
#include <vector>

#include "calib/edge/edge_curve.h"

namespace calib {

struct NamedRoi {
  Roi roi{};
  std::string name{};  ///< "" when there is none
  int line = 0;        ///< of the file, from 1
};

/// "x,y,width,height". Throws UsageError.
Roi parse_roi(std::string_view text);

/// All regions of a file, in order; at most 100 000. Throws UsageError with a line "file:line: ..." for each that is
/// wrong, up to 20, and for a file without any. Whether they lie in the image is checked by the measurement.
std::vector<NamedRoi> parse_roi_file(std::string_view text, const std::string& source);

}  // namespace calib
