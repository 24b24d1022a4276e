// SPDX-License-Identifier: Apache-2.0
#pragma once

// Reading of OpenEXR for `read_info` and `read_image`.

#include <string>

#include "mtf/io/image_io.h"

namespace mtf::io {

FileInfo read_exr_info(const std::string& path);
ImageFile read_exr(const std::string& path, const ReadOptions& options);

}  // namespace mtf::io
