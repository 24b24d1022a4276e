// SPDX-License-Identifier: Apache-2.0
#pragma once

// What a TIFF says beside the size and the type of its samples (TIFF 6.0; Adobe DNG 1.7; GeoTIFF; tags of GDAL): which
// of its images is the first, which pixels are no data, how values are meant. Only sources of the module include this.

#include <tiffio.h>

#include <cstdint>
#include <string>
#include <vector>

#include "mtf/io/codecs/codecs.h"

namespace mtf::io::module {

/// One image of the file.
struct TiffImage {
  std::uint32_t kind = 0;  ///< NewSubfileType
  std::uint32_t width = 0, height = 0;
  int photometric = 0;
};

/// The images beside the first: those of the chain of directories, and those in SubIFDs of the first one.
struct TiffOthers {
  std::vector<TiffImage> pages, below;
};

inline constexpr int kLinearRaw = 34892;  ///< photometric interpretation of DNG
inline constexpr const char* kRawRemedy =
    "it is a camera's raw file: write the raw values as a TIFF, as `unprocessed_raw -T` of LibRaw does, and read that";

/// "a colour filter array".
std::string photometric_name(int photometric);

/// Leaves the handle at the first image.
TiffOthers other_images(TIFF* tiff);

/// Throws RuntimeError, with what the file holds and how it is got at, when the first image is a preview of another one
/// or a mask, and when another image is a mask of the first.
void require_main_image(const std::string& path, TIFF* tiff, const TiffOthers& others);

/// No data, the shape of pixels and notes.
void read_tags(TIFF* tiff, const TiffOthers& others, RasterHeader& header);

}  // namespace mtf::io::module
