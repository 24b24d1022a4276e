// SPDX-License-Identifier: Apache-2.0
#pragma once

// Images whose numbers lie bare in a file, one after another, as in ENVI, FITS, binary PGM and PPM, BMP and FLIR: their
// headers only differ in how they say where. The sample of plane p at column x and row y lies at
//   begin + p plane_step + y row_step + x pixel_step
// bytes; steps are negative where rows go upwards or colours are in the order B,G,R. Windows are read on their own, so
// that such images need not fit memory.

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "mtf/image.h"
#include "mtf/io/image_io.h"
#include "mtf/io/raw/number_type.h"

namespace mtf::io {

struct RawImage {
  std::string file;        ///< that holds the numbers
  std::vector<char> held;  ///< the numbers themselves, where the file has them in digits; `begin` counts from its start
  std::function<std::vector<char>()> unpack{};  ///< makes `held` when the image is read, where numbers are compressed
  NumberType type{};
  std::int64_t begin = 0, pixel_step = 0, row_step = 0, plane_step = 0;
  std::vector<Meaning> planes{};  ///< one a plane
  /// Pixels from (x, y) on of a plane as floats, from any thread, where the numbers do not lie bare: a library decodes.
  std::function<void(std::int64_t plane, std::int64_t x, std::int64_t y, ImageView<float> out, Rounding* rounding)>
      decode{};
  FileInfo info{};  ///< format, size, and with channels() one for each plane
};

/// Throws RuntimeError unless the image, whose size, type and file are known, has pixels and planes, at most as many as
/// are read at all, and its samples lie in the file from byte `begin` on: nothing is allocated before. `path` is the
/// file that the user named. Returns how many bytes follow.
std::int64_t check_samples(const std::string& path, const RawImage& image, std::int64_t begin, std::int64_t planes,
                           std::int64_t row_padding = 0);

/// Pixel after pixel, each with the samples of all planes, row after row.
void interleave_pixels(RawImage& image, std::int64_t row_padding = 0);

/// Completes `info`: windows, and channels of these names.
void name_channels(RawImage& image, const std::vector<std::string>& names, int part = 0);

/// Samples that are `value` have no data. `words` say so: "0 (BLANK)".
void set_no_data(RawImage& image, double value, const std::string& words);

/// Planes of a file, which are channels with names: more take seconds to list and to choose from.
inline constexpr std::int64_t kMostRawPlanes = 1 << 16;

// The images in a file of each format; several only in FITS, FLIR and those of GDAL, where ReadOptions::part chooses:
// then GDAL opens no other. Only headers are read. Throw RuntimeError for headers that are damaged, that lack what the
// numbers cannot be read without, or that ask for what is not read; messages name the key.
using Part = std::optional<int>;
std::vector<RawImage> open_envi(const std::string& path, Part part);
std::vector<RawImage> open_fits(const std::string& path, Part part);
std::vector<RawImage> open_pnm(const std::string& path, Part part);
std::vector<RawImage> open_bmp(const std::string& path, Part part);
/// FFF and SEQ, a frame a part; or the counts in a JPEG (mtf/io/raw/flir.cpp).
std::vector<RawImage> open_flir(const std::string& path, Part part);
/// By the module of GDAL; also throws as open_module does, and UsageError for many images without a part.
std::vector<RawImage> open_gdal(const std::string& path, Part part);
/// By the module of LibRaw, likewise.
std::vector<RawImage> open_camera_raw(const std::string& path, Part part);
using OpenRaw = std::vector<RawImage> (*)(const std::string& path, Part part);

/// Of the part that is asked for, the first where it is none; `channels` are those of all that were opened.
FileInfo read_raw_info(const std::string& path, OpenRaw open, Part part = std::nullopt);
ImageFile read_raw(const std::string& path, OpenRaw open, const ReadOptions& options);

/// Windows of the chosen channels, from any thread.
class RawWindows {
 public:
  /// Opens and checks; errors as read_image, but for the memory that whole planes would need.
  RawWindows(const std::string& path, OpenRaw open, const ReadOptions& options);
  ~RawWindows();
  RawWindows(const RawWindows&) = delete;
  RawWindows& operator=(const RawWindows&) = delete;

  /// As read_image has it, without planes.
  const ImageFile& file() const { return file_; }
  /// Pixels from (x, y) on of consecutive chosen channels, one a view of `out`, all of one size. Throws RuntimeError
  /// where the file has become shorter. `rounding` has one for each view, or none.
  void read(std::size_t first_channel, std::int64_t x, std::int64_t y, std::span<const ImageView<float>> out,
            std::span<Rounding> rounding = {}) const;
  /// Notes in file() what float32 takes from the chosen channels, which are read once. Throws as Rounding::note.
  void note_rounding();

 private:
  RawImage image_;
  ImageFile file_;
  std::vector<std::int64_t> chosen_;  ///< planes
  int descriptor_ = -1;
};

}  // namespace mtf::io
