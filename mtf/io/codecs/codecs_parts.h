// SPDX-License-Identifier: Apache-2.0
#pragma once

// The functions in the table of codecs.h and what they share; only sources of the module include this.

#include <string>
#include <vector>

#include "mtf/io/codecs/codecs.h"
#include "mtf/io/float_rounding.h"

namespace mtf::io::module {

RasterHeader tiff_header(const std::string& path, std::int64_t file_bytes, int page);
std::vector<Image> decode_png(const std::string& path, std::istream& file, std::int64_t bytes,
                              const RasterHeader& header);
std::vector<Image> decode_tiff(const std::string& path, RasterHeader& header);
std::vector<Image> decode_jpeg(const std::string& path, const RasterHeader& header);
int encode_png(int descriptor, const RasterData& data);
int encode_tiff(int descriptor, const RasterData& data);

/// Stops libtiff from writing to stderr; its messages are replaced by ours.
void silence_tiff();

/// Writes all bytes; returns 0 or the error number.
int write_all(int descriptor, const void* data, std::size_t size);

/// Planes of the size that the header announces, one a colour.
std::vector<Image> empty_planes(const RasterHeader& header);

/// Decoded samples of a rectangle, of the header's type; colours are the first samples of each pixel.
struct Piece {
  const void* samples;
  std::int64_t x, y, width, height;
  std::int64_t row_samples;  ///< from row to row
  int pixel_samples;         ///< from pixel to pixel
  Rounding* rounding{};      ///< one a plane, for doubles
};

/// Copies the part of the piece that lies in the image.
void place(const Piece& piece, const RasterHeader& header, std::vector<Image>& planes);

/// Pixels without data become NaN.
void mark_no_data(const RasterHeader& header, std::vector<Image>& planes);

/// Throws RuntimeError where a file is no longer the one whose header was read.
void require_same(const RasterHeader& now, const RasterHeader& header, const std::string& path,
                  const std::string& format);

[[noreturn]] void undecodable(const std::string& path, const std::string& format, const std::string& why);

}  // namespace mtf::io::module
