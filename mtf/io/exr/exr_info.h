// SPDX-License-Identifier: Apache-2.0
#pragma once

// What the headers of an open OpenEXR file say, as `FileInfo`.

#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfMultiPartInputFile.h>

#include "mtf/io/image_io.h"

namespace mtf::io {

FileInfo describe_exr(const Imf::MultiPartInputFile& file);

/// True for parts stored in tiles (by type, or by the tile description of old single-part files).
bool exr_part_tiled(const Imf::Header& header);

}  // namespace mtf::io
