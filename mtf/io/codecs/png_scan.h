// SPDX-License-Identifier: Apache-2.0
#pragma once

// PNG files chunk by chunk, without decoding pixels (format: PNG specification, ISO/IEC 15948).

#include <string>
#include <vector>

#include "mtf/io/codecs/codecs.h"

namespace mtf::io {

/// Reads header, text and the chunks that say how values follow from light, and checks the length and CRC of every
/// chunk up to IEND: a file that is cut short or altered is refused with RuntimeError before anything decodes it. When
/// `critical` is given it receives the file with only the chunks that the pixels need (colour profiles and the like
/// make decoders talk).
RasterHeader scan_png(const std::string& path, std::vector<unsigned char>* critical = nullptr);

}  // namespace mtf::io
