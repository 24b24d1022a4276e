// SPDX-License-Identifier: Apache-2.0
#pragma once

// Numbers of a component over the field from CSV files, a row a position:
//   # lens 12, design of 2024-03-01
//   r (deg),w131,Z4
//   0,0,0.02
//   10,0.4,0.11
// Positions are columns x and y, +x right and +y down, or r, the distance from the optical axis; the unit stands in
// brackets or as a suffix (x_mm): a length at the focal plane, an angle of the field (place = focal length x tangent,
// along each axis), px, or none, where 1 is half the diagonal of the detector. Positions in px are counted from the
// corner of the detector, all others, and r in px, from the optical axis. All other columns are values, called as the
// key of the component, with their unit where they have one: rms (urad). Separators and comments as in curve_csv.h.

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "mtf/field_terms.h"

namespace mtf::io {

/// Throws RuntimeError when the file cannot be read, UsageError for what is wrong in it.
std::shared_ptr<const FieldMap> read_field_map_csv(const std::string& path);
/// The same from text.
std::shared_ptr<const FieldMap> parse_field_map_csv(std::string_view text, const std::string& source);

/// Files at positions: a table with the column `file` in place of values. Errors as above.
struct FieldFiles {
  FieldMap positions;             ///< without columns; not made yet
  std::vector<std::string> file;  ///< of each
};
FieldFiles read_field_files_csv(const std::string& path);

}  // namespace mtf::io
