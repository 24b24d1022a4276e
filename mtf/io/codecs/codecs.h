// SPDX-License-Identifier: Apache-2.0
#pragma once

// The interface to PNG, TIFF and JPEG. Their libraries load a dozen others, so the functions of this table are in a
// module (mtf/work/module.h, CMake target `mtfkit_codecs`), opened on first use: reading no PNG costs nothing.

#include <cstdint>
#include <istream>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "mtf/image.h"
#include "mtf/io/codecs/stated_encoding.h"
#include "mtf/work/module.h"

namespace mtf::io {

/// A stored value that means that a pixel has none: such pixels are NaN in the planes.
struct NoData {
  float value = 0.0F;
  std::string words;  ///< "0 (GDAL_NODATA)"
};

/// A PNG, TIFF or JPEG as its header describes it, sizes already checked against the file.
struct RasterHeader {
  std::int64_t width = 0, height = 0;
  int colours = 1;     ///< 1 grey, 3 R,G,B
  bool alpha = false;  ///< one more channel, never read
  std::string type;    ///< "uint8", "uint16", "int8", "int16", "float", "double"
  std::string storage;
  std::map<std::string, std::string> attributes;
  StatedEncoding encoding;
  std::vector<std::uint16_t> dct_steps{};  ///< of a JPEG (mtf/io/codecs/encoding.h)
  std::optional<NoData> no_data{};
  double pixel_aspect = 1.0;         ///< as in FileInfo
  double largest = 0.0;              ///< as in FileInfo
  int page = 0;                      ///< of a TIFF, from 0
  std::vector<std::string> notes{};  ///< as in FileInfo
  std::string flir{}, dji{};         ///< FFF, and counts, in the segments of a JPEG (mtf/io/raw/flir.cpp)
};

/// Samples to be written, row-major, colours interleaved as R,G,B, 8 or 16 bits each.
struct RasterData {
  std::int64_t width = 0, height = 0;
  int colours = 1;
  int bits = 16;
  std::vector<std::uint16_t> samples;
  std::vector<std::pair<std::string, std::string>> text;
};

struct Drawing;

/// The picture, enlarged and drawn upon; `data` has 3 colours of 8 bits, all three the grey value for false colours.
RasterData drawn(const RasterData& data, const Drawing& drawing);

/// Functions of the module. Reading throws RuntimeError naming `path`; writing goes to a descriptor at position 0 and
/// returns 0 or the error number of the write that failed.
struct Codecs {
  ModuleBuild build;
  RasterHeader (*tiff_header)(const std::string& path, std::int64_t file_bytes, int page);
  /// Planes in the order R,G,B or Y, values as stored.
  /// Of a PNG of that many bytes in a file or in memory, which `path` names.
  std::vector<Image> (*decode_png)(const std::string& path, std::istream& file, std::int64_t bytes,
                                   const RasterHeader& header);
  /// Adds to the header's notes what float32 takes from doubles.
  std::vector<Image> (*decode_tiff)(const std::string& path, RasterHeader& header);
  std::vector<Image> (*decode_jpeg)(const std::string& path, const RasterHeader& header);
  /// Counts of 9 to 16 bits, as 16 bits of this machine, of a JPEG-LS in memory; null where CharLS was not there.
  std::vector<char> (*decode_jpeg_ls)(const std::string& path, const std::string& bytes, std::int64_t width,
                                      std::int64_t height);
  int (*encode_png)(int descriptor, const RasterData& data);
  int (*encode_tiff)(int descriptor, const RasterData& data);
};

/// The module's table, opened on first use. Thread-safe. Throws as open_module does.
const Codecs& codecs();

/// Whether the module is there; opens nothing.
bool has_codecs();

}  // namespace mtf::io
