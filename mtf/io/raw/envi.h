// SPDX-License-Identifier: Apache-2.0
#pragma once

// ENVI: numbers in one file and a header of text, NAME.hdr, beside it. Lines `key = value`, a value in braces may go on
// over several; keys in any case; ';' starts a comment line. Source: "ENVI Header Files" of NV5's documentation.
//
//   samples, lines, bands   columns, rows, planes
//   data type               1 uint8, 2 int16, 3 int32, 4 float, 5 double, 12 uint16, 13 uint32, 14 int64, 15 uint64
//   byte order              0 the least byte first, 1 the greatest; may be missing for one byte
//   interleave              bsq plane after plane, bil row after row of all planes, bip pixel after pixel
//   header offset           bytes before the numbers, 0 where it is missing
//   data gain values, data offset values   one a band, applied: value = gain x stored + offset
//   data ignore value       stored number of pixels without data, NaN here
//   wavelength, wavelength units           of bands, for spectra; without units an error
//   map info                sizes of pixels, where they are no squares
// All other keys are attributes of the image and change no value; those that might are noted.

#include <string>
#include <vector>

#include "mtf/io/image_io.h"

namespace mtf::io {

/// The header of the image that `path` names, which is one or lies beside one; "" where there is none.
std::string envi_header_of(const std::string& path);

/// Header and numbers of such an image. Throws where its numbers are not there, or cannot be told.
std::vector<std::string> envi_files_of(const std::string& path);

/// The files that are written for `path`, which ends in .hdr or .img: header and numbers.
std::vector<std::string> envi_files(const std::string& path);

/// Floats, the least byte first; metadata are keys of the header. Rows are asked for in order, some at a time. Both
/// files appear whole or not at all.
void write_envi(const std::string& path, const std::vector<std::string>& names, std::int64_t width, std::int64_t height,
                const ReadRows& rows, const Metadata& metadata);

}  // namespace mtf::io
