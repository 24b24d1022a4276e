// SPDX-License-Identifier: Apache-2.0
#pragma once

// What PNG and JPEG have in common beside their pixels: single values of Exif, which has the layout of a TIFF (CIPA
// DC-008), and densities of pixels.

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace mtf::io {

/// The value of a tag in the first directory, a whole number of 16 or 32 bits; nothing when it is not there.
std::optional<std::uint32_t> tag_value(std::span<const unsigned char> tiff, std::uint16_t tag);

/// Adds a note where the orientation of the Exif data is not that of the rows and columns as stored.
void note_orientation(std::span<const unsigned char> exif, std::vector<std::string>& notes);

/// Width of a pixel over its height, from pixels per length along x and y, which are rounded to whole numbers; 1 when
/// one of them is 0.
double aspect_of_densities(std::uint32_t x, std::uint32_t y);

}  // namespace mtf::io
