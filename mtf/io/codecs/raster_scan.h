// SPDX-License-Identifier: Apache-2.0
#pragma once

// PNG files chunk by chunk (PNG specification, ISO/IEC 15948) and JPEG files segment by segment (ITU-T T.81, annex B;
// JFIF; the Adobe marker of T.872), without decoding pixels.

#include <istream>
#include <string>
#include <vector>

#include "mtf/io/codecs/codecs.h"

namespace mtf::io {

/// Reads header, text and the chunks that say how values follow from light, and checks the length and CRC of every
/// chunk up to IEND: a file that is cut short or altered is refused with RuntimeError before anything decodes it. When
/// `critical` is given it receives the file with only the chunks that the pixels need (colour profiles and the like
/// make decoders talk).
RasterHeader scan_png(const std::string& path);
/// The same of a PNG of that many bytes in a file or in memory, which `path` names.
RasterHeader scan_png(const std::string& path, std::istream& file, std::int64_t file_bytes,
                      std::vector<unsigned char>* critical = nullptr);

/// The header for the luminance plane, the only one that is read: chroma is mixed of colours, and mostly of fewer
/// pixels. Checks every segment up to the end of the image; a file that is cut short, of more than 8 bits, stored as
/// RGB or CMYK or by a process that is hardly ever used (lossless, hierarchical, arithmetic) is refused with
/// RuntimeError before anything decodes it. When `critical` is given it receives the file without applications'
/// segments, orientation among them: pixels stay as they are stored.
RasterHeader scan_jpeg(const std::string& path, std::vector<unsigned char>* critical = nullptr);

}  // namespace mtf::io
