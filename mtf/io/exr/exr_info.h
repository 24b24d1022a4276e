// SPDX-License-Identifier: Apache-2.0
#pragma once

// What the headers of an open OpenEXR file say, as `FileInfo`.

#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfMultiPartInputFile.h>

#include "mtf/io/image_io.h"

namespace mtf::io {

/// Windows, shape of pixels and notes are those of `part`, and so are the attributes that it has.
FileInfo describe_exr(const Imf::MultiPartInputFile& file, int part = 0);

/// True for parts stored in tiles (by type, or by the tile description of old single-part files).
bool exr_part_tiled(const Imf::Header& header);

}  // namespace mtf::io
