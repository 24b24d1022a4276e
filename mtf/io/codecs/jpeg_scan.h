// SPDX-License-Identifier: Apache-2.0
#pragma once

// JPEG files segment by segment, without decoding pixels (ITU-T T.81, annex B; JFIF; the Adobe marker of T.872).

#include <string>
#include <vector>

#include "mtf/io/codecs/codecs.h"

namespace mtf::io {

/// The header for the luminance plane, the only one that is read: chroma is mixed of colours, and mostly of fewer
/// pixels. Checks every segment up to the end of the image; a file that is cut short, of more than 8 bits, stored as
/// RGB or CMYK or by a process that is hardly ever used (lossless, hierarchical, arithmetic) is refused with
/// RuntimeError before anything decodes it. When `critical` is given it receives the file without applications'
/// segments, orientation among them: pixels stay as they are stored.
RasterHeader scan_jpeg(const std::string& path, std::vector<unsigned char>* critical = nullptr);

}  // namespace mtf::io
