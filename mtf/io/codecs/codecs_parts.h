// SPDX-License-Identifier: Apache-2.0
#pragma once

// The functions in the table of codecs.h; only sources of the module include this.

#include <string>
#include <vector>

#include "mtf/io/codecs/codecs.h"

namespace mtf::io::module {

RasterHeader tiff_header(const std::string& path, std::int64_t file_bytes);
/// Decodes every strip or tile and drops it. OpenCV prints to stderr when decoding fails and may fill in zeros: damaged
/// files are found here first. Throws RuntimeError.
void verify_tiff(const std::string& path);
std::vector<Image> decode_png(const std::string& path, const RasterHeader& header);
std::vector<Image> decode_tiff(const std::string& path, const RasterHeader& header);
std::vector<Image> decode_jpeg(const std::string& path, const RasterHeader& header);
int encode_png(int descriptor, const RasterData& data);
int encode_tiff(int descriptor, const RasterData& data);
OpenCvFilter make_filter(const OpenCvJob& job);
RasterData draw(const RasterData& data, const Drawing& drawing);

/// Stops libtiff from writing to stderr; its messages are replaced by ours.
void silence_tiff();

/// Writes all bytes; returns 0 or the error number.
int write_all(int descriptor, const void* data, std::size_t size);

}  // namespace mtf::io::module
