// SPDX-License-Identifier: Apache-2.0
#pragma once

// The one table of image formats: how a file is known, who reads it, what of it is applied, noted and refused. Readers,
// writers, messages, `mtf info --formats` and the README follow from it.

#include <array>
#include <span>
#include <string>
#include <string_view>

#include "mtf/io/image_io.h"
#include "mtf/io/raw/raw_image.h"

namespace mtf::io {

struct ImageFormat {
  Format format{};
  std::string_view name;                      ///< "OpenEXR"
  std::string_view known_by;                  ///< what makes a file one of this format
  std::string_view numbers;                   ///< that are read
  std::array<std::string_view, 2> endings{};  ///< of names under which images are written; "" = none
  std::string_view written{};                 ///< numbers that are written; "" = the format is only read
  std::string_view applied, noted, refused;
  bool (*starts)(std::string_view bytes);  ///< whether a file that starts so is one
  OpenRaw raw = nullptr;                   ///< of formats that are read as bare numbers
  /// Whether windows of it can be read (mtf/io/image_windows.h).
  bool in_pieces() const { return format == Format::exr || (raw != nullptr && format != Format::camera_raw); }
};

std::span<const ImageFormat> image_formats();
const ImageFormat& row_of(Format format);

/// read_info() of one part or page, the first where none is asked for.
FileInfo read_info_of(const std::string& path, std::optional<int> part);

}  // namespace mtf::io
