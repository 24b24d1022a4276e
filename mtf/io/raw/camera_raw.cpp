// SPDX-License-Identifier: Apache-2.0
#include "mtf/io/raw/camera_raw.h"

#include <algorithm>
#include <memory>
#include <mutex>

#include "mtf/error.h"
#include "mtf/io/file_checks.h"
#include "mtf/io/raw/raw_image.h"
#include "mtf/units.h"
#include "mtf/words.h"

namespace mtf::io {
namespace {

constexpr Module kLibRaw{.name = "mtfkit_libraw",
                         .what = "LibRaw, which reads DNG and the raw files of cameras",
                         .in_all = true,
                         .package = "mtfkit-libraw"};

const LibRawCodec& libraw() {
  static const LibRawCodec& table = open_module<LibRawCodec>(kLibRaw);
  return table;
}

/// Decoded whole when the first pixel is asked for.
struct Counts {
  std::once_flag decoded;
  std::vector<std::uint16_t> values;
};

void describe(const CameraRaw& camera, FileInfo& info) {
  const auto& [least, most] = std::ranges::minmax(camera.black);
  const std::string black = least == most ? format_double(least) : joined(camera.black, format_double, " ");
  info.attributes = {{"camera", camera.camera}, {"mosaic", camera.pattern}, {"black level", black}};
  if (camera.exposure_s > 0.0) info.attributes["exposure"] = significant(camera.exposure_s, 6) + " s";
  if (camera.iso > 0.0) info.attributes["ISO speed"] = format_double(camera.iso);
  info.notes.push_back("counts of the sensor under the mosaic " + camera.pattern + " (mtf measure --pattern " +
                       camera.pattern + "), not demosaiced; the black level of " + black +
                       " counts is not subtracted ([scene] offset)");
  if (camera.turned) info.notes.emplace_back("rows are as the sensor reads them; the orientation is not applied");
}

}  // namespace

bool is_camera_raw(const std::string& path) {
  constexpr std::array<std::string_view, 10> endings{".dng", ".nef", ".cr2", ".cr3", ".arw",
                                                     ".orf", ".raf", ".rw2", ".pef", ".srw"};
  const std::string name = lower_case(path);
  return std::ranges::any_of(endings, [&](std::string_view ending) { return name.ends_with(ending); });
}

std::vector<RawImage> open_camera_raw(const std::string& path, Part) {
  const CameraRaw camera = libraw().header(path);
  check_plane_pixels(path, camera.width, camera.height);
  RawImage image;
  image.file = path;
  image.type = {'u', 2};
  image.planes.resize(1);
  FileInfo& info = image.info;
  info.format = Format::camera_raw;
  info.storage = "mosaic";
  info.width = camera.width;
  info.height = camera.height;
  info.largest = camera.white;
  info.pixel_aspect = camera.pixel_aspect;
  describe(camera, info);
  name_channels(image, {"Y"});
  image.decode = [path, width = camera.width, size = camera.width * camera.height, counts = std::make_shared<Counts>()](
                     std::int64_t, std::int64_t x, std::int64_t y, ImageView<float> out, Rounding*) {
    std::call_once(counts->decoded, [&] {
      counts->values = libraw().counts(path);
      if (std::ssize(counts->values) != size)
        throw RuntimeError("cannot read " + path + ": it changed while it was read");
    });
    for (std::int64_t row = 0; row < out.height; ++row)
      std::copy_n(counts->values.begin() + (y + row) * width + x, out.width, out.row(row));
  };
  std::vector<RawImage> images;
  images.push_back(std::move(image));
  return images;
}

}  // namespace mtf::io
