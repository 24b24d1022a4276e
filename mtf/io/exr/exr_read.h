// SPDX-License-Identifier: Apache-2.0
#pragma once

// Reading of OpenEXR: whole images for `read_info` and `read_image`, and windows of files that need not fit memory.

#include <memory>
#include <string>

#include "mtf/io/image_io.h"

namespace mtf::io {

FileInfo read_exr_info(const std::string& path);
ImageFile read_exr(const std::string& path, const ReadOptions& options);

/// Windows of pixels, decoded in bands of rows that are kept for a while.
class ExrWindows {
 public:
  /// Opens and checks; reads no pixels. Errors as read_image, but for the memory that whole planes would need.
  ExrWindows(const std::string& path, const ReadOptions& options);
  ~ExrWindows();
  ExrWindows(const ExrWindows&) = delete;
  ExrWindows& operator=(const ExrWindows&) = delete;

  /// As read_image has it, without planes.
  const ImageFile& file() const;
  /// Bytes of one row of all chosen channels.
  std::int64_t row_bytes() const;
  /// How many rows stay decoded: those of one row of tiles, or neighbouring tiles decode the same rows again. At most
  /// more_rows() others that share a band with them stay too.
  void keep_rows(std::int64_t rows);
  std::int64_t more_rows() const;
  /// Pixels of the chosen channel `channel` from (x, y) of the display window; 0 where the file has none. From any
  /// thread, and each decodes on its own. Throws RuntimeError for damaged pixels.
  void read(std::size_t channel, std::int64_t x, std::int64_t y, ImageView<float> out) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace mtf::io
