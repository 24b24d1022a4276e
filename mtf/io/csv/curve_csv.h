// SPDX-License-Identifier: Apache-2.0
#pragma once

// MTF curves from CSV files:
//   # lens 12, on axis, bench of 2024-03-01
//   frequency_cy_mm,mtf
//   0,1
//   10,0.93
// The header names two columns; the frequency carries its unit as a suffix or in brackets: frequency_cy_mm,
// "frequency (cy/mm)", f_cy_px, "freq [cycles/mrad]". Columns are separated by comma, semicolon or tab; `#` starts a
// comment line. Further columns are an error unless the ones to read are called frequency… and mtf.

#include <string>
#include <string_view>

#include "mtf/component.h"

namespace mtf::io {

/// A file of at most 64 MiB and a million rows. Throws RuntimeError when it cannot be read, UsageError "file:line: …"
/// for what is wrong in it.
Curve read_curve_csv(const std::string& path);

/// The same from text; `source` is what messages and Curve::source call it.
Curve parse_curve_csv(std::string_view text, const std::string& source);

/// A whole file of at most `limit` bytes (a pipe will do). Throws RuntimeError: missing, a folder, too large.
std::string read_file(const std::string& path, std::size_t limit);
/// The same of a text file; throws for an image in its place, too.
std::string read_text_file(const std::string& path, std::size_t limit);

}  // namespace mtf::io
