// SPDX-License-Identifier: Apache-2.0
// The module of LibRaw, the only file that sees it.

#include <libraw/libraw.h>

#include <algorithm>
#include <cctype>
#include <memory>

#include "mtf/error.h"
#include "mtf/io/raw/camera_raw.h"
#include "mtf/version.h"

namespace mtf::io {
namespace {

[[noreturn]] void fail(const std::string& path, const std::string& why) {
  throw RuntimeError("cannot read " + path + ": " + why + "; convert it to an uncompressed DNG, or export a TIFF");
}

/// On the heap: it has megabytes.
std::unique_ptr<LibRaw> opened(const std::string& path) {
  auto raw = std::make_unique<LibRaw>(LIBRAW_OPIONS_NO_DATAERR_CALLBACK);
  if (const int error = raw->open_file(path.c_str()); error != LIBRAW_SUCCESS)
    fail(path, std::string("LibRaw says: ") + libraw_strerror(error));
  const auto& color = raw->imgdata.idata;
  if (color.filters == 0 || color.is_foveon != 0)
    fail(path, "it has no mosaic of colour filters: its pixels are processed, or have all colours");
  if (color.filters != (color.filters & 0xFFU) * 0x01010101U)  // eight rows of two pixels, 2 bits each
    fail(path, "its mosaic does not repeat after two pixels (as X-Trans), which is not read");
  return raw;
}

CameraRaw header(const std::string& path) {
  const std::unique_ptr<LibRaw> raw = opened(path);
  const auto& data = raw->imgdata;
  CameraRaw camera{.camera = std::string(data.idata.make) + " " + data.idata.model,
                   .pattern = {},
                   .width = data.sizes.width,
                   .height = data.sizes.height,
                   .white = static_cast<double>(data.color.maximum),
                   .pixel_aspect = data.sizes.pixel_aspect,
                   .exposure_s = std::max(data.other.shutter, 0.0F),
                   .iso = std::max(data.other.iso_speed, 0.0F),
                   .turned = data.sizes.flip != 0};
  for (int i = 0; i < 4; ++i) {
    const int colour = raw->COLOR(i / 2, i % 2);
    camera.pattern += static_cast<char>(std::tolower(static_cast<unsigned char>(data.idata.cdesc[colour])));
    // A pattern of levels of its own stands behind the four of the colours, from its corner.
    const unsigned rows = data.color.cblack[4], columns = data.color.cblack[5];
    if (rows > 2 || columns > 2) fail(path, "its black level does not repeat after two pixels, which is not read");
    const unsigned at = rows * columns == 0 ? 0 : (i / 2 % rows) * columns + i % 2 % columns;
    camera.black[static_cast<std::size_t>(i)] =
        data.color.black + data.color.cblack[colour] + (rows * columns == 0 ? 0 : data.color.cblack[6 + at]);
  }
  return camera;
}

std::vector<std::uint16_t> counts(const std::string& path) {
  const std::unique_ptr<LibRaw> raw = opened(path);
  if (const int error = raw->unpack(); error != LIBRAW_SUCCESS)
    fail(path, std::string("LibRaw says: ") + libraw_strerror(error));
  if (raw->error_count() > 0) fail(path, "its pixels are damaged or cut off");
  const auto& data = raw->imgdata;
  if (data.rawdata.raw_image == nullptr) fail(path, "its pixels are no whole numbers under a mosaic");
  std::vector<std::uint16_t> counts;
  counts.reserve(std::size_t{data.sizes.width} * data.sizes.height);
  for (unsigned row = 0; row < data.sizes.height; ++row) {
    const unsigned short* from = data.rawdata.raw_image +
                                 (row + data.sizes.top_margin) * std::size_t{data.sizes.raw_pitch / 2} +
                                 data.sizes.left_margin;
    counts.insert(counts.end(), from, from + data.sizes.width);
  }
  return counts;
}

constexpr LibRawCodec kTable{.build = {version, git_commit}, .header = header, .counts = counts};

}  // namespace
}  // namespace mtf::io

extern "C" __attribute__((visibility("default"))) const void* mtfkit_libraw_table() { return &mtf::io::kTable; }
