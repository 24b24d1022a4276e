// SPDX-License-Identifier: Apache-2.0
#pragma once

// PNG, TIFF and JPEG, whose pixels the module of codecs.h decodes, as `read_info` and `read_image` give them.

#include <string>

#include "mtf/io/image_io.h"

namespace mtf::io {

FileInfo read_raster_info(const std::string& path, Format format, int page = 0);
ImageFile read_raster(const std::string& path, Format format, const ReadOptions& options);

}  // namespace mtf::io
