// SPDX-License-Identifier: Apache-2.0
#pragma once

// Checks that every reader makes before it trusts a file: what the path is, and whether the announced size is possible.

#include <cstdint>
#include <string>

namespace mtf::io {

/// Largest number of pixels of one plane that is read or written.
inline constexpr std::int64_t max_plane_pixels = std::int64_t{1} << 31;

/// Size in bytes of an ordinary file. Throws RuntimeError for anything else: missing, folder, device, pipe, which to
/// open would wait for its other end. Every reader asks it before it opens a file.
std::int64_t ordinary_file_size(const std::string& path);

/// The same of a file that is not empty.
std::int64_t input_file_size(const std::string& path);

/// Throws RuntimeError when a plane of this size is empty or above `max_plane_pixels`.
void check_plane_pixels(const std::string& path, std::int64_t width, std::int64_t height);

/// Throws RuntimeError with the bytes needed when `planes` float planes of this size are above `max_plane_pixels` each
/// or more than the usable memory. Nothing is allocated.
void check_plane_size(const std::string& path, std::int64_t width, std::int64_t height, std::int64_t planes);

/// Throws RuntimeError when a PNG or TIFF, as `what` says, has more than 2^20 pixels a side or 2^30 in all.
void check_raster_size(const std::string& path, const std::string& what, std::int64_t width, std::int64_t height);

/// Throws RuntimeError when a file of `file_bytes` cannot hold `data_bytes` at a compression of `ratio`.
void check_compression(const std::string& path, double data_bytes, std::int64_t file_bytes, double ratio);

/// "1.5 GiB": for messages.
std::string shown_bytes(double bytes);

}  // namespace mtf::io
