// SPDX-License-Identifier: Apache-2.0
#pragma once

// Windows of an image file that need not fit memory, whatever its format.

#include <memory>
#include <string>

#include "mtf/io/exr/exr_read.h"
#include "mtf/io/raw/raw_image.h"

namespace mtf::io {

class ImageWindows {
 public:
  /// Opens and checks; reads no pixels but those of numbers that float32 may change. Throws as read_image, but for the
  /// memory that whole planes would need, and UsageError for formats that cannot be read in pieces.
  ImageWindows(const std::string& path, const ReadOptions& options);

  /// As read_image has it, without planes.
  const ImageFile& file() const { return exr_ ? exr_->file() : raw_->file(); }
  /// Bytes that stay in memory for each row of all chosen channels, and how many rows of other windows stay besides.
  std::int64_t row_bytes() const { return exr_ ? exr_->row_bytes() : 0; }
  std::int64_t more_rows() const { return exr_ ? exr_->more_rows() : 0; }
  /// How many rows a row of tiles needs.
  void keep_rows(std::int64_t rows) {
    if (exr_) exr_->keep_rows(rows);
  }
  /// Pixels of the chosen channel from (x, y) on, from any thread.
  void read(std::size_t channel, std::int64_t x, std::int64_t y, ImageView<float> out) const {
    if (exr_)
      exr_->read(channel, x, y, out);
    else
      raw_->read(channel, x, y, {&out, 1});
  }

 private:
  std::unique_ptr<ExrWindows> exr_;
  std::unique_ptr<RawWindows> raw_;
};

}  // namespace mtf::io
