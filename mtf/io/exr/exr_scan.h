// SPDX-License-Identifier: Apache-2.0
#pragma once

// Checks the raw header of an OpenEXR file before the library opens it. The library allocates what a header asks
// for; a damaged header may ask for anything. The scan walks the attributes of every part (format: OpenEXR file layout,
// version 2) and refuses what the file cannot hold.

#include <cstdint>
#include <string>

namespace mtf::io {

/// A data or display window: the first and the last column and row, both inside.
struct Window {
  std::int64_t x0, y0, x1, y1;
  std::int64_t width() const { return x1 - x0 + 1; }
  std::int64_t height() const { return y1 - y0 + 1; }
};

/// Throws RuntimeError when the header is cut short, an attribute is longer than the file, a window is inverted, the
/// chunk table cannot fit, or the announced pixels (or one tile) are far beyond what the file can hold compressed.
void scan_exr_header(const std::string& path);

/// Lines of one chunk of a scan-line part with this compression code, 0 for an unknown one.
int exr_chunk_lines(int compression);

}  // namespace mtf::io
