// SPDX-License-Identifier: Apache-2.0
#include "mtf/io/raw/gdal.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <memory>
#include <mutex>

#include "mtf/io/file_checks.h"
#include "mtf/io/raw/raw_image.h"
#include "mtf/units.h"
#include "mtf/words.h"

namespace mtf::io {
namespace {

constexpr Module kGdal{.name = "mtfkit_gdal",
                       .what = "GDAL, which reads NITF, HDF5 and JPEG 2000",
                       .in_all = true,
                       .package = "mtfkit-gdal"};

const Gdal& gdal() {
  static const Gdal& table = open_module<Gdal>(kGdal);
  return table;
}

/// Rows that are decoded at once: numbers of double precision are a few MiB.
std::int64_t strip_rows(std::int64_t width, std::int64_t height) {
  return std::clamp((std::int64_t{1} << 19) / width, std::int64_t{1}, height);
}

RawImage image_of(const std::string& path, GdalImage from, int part) {
  RawImage image;
  image.file = path;
  image.type = {from.bands.front().kind, from.bands.front().bytes};
  FileInfo& info = image.info;
  info.format = Format::gdal;
  info.storage = from.format;
  info.width = from.width;
  info.height = from.height;
  if (const auto& t = from.geotransform) {
    info.attributes["geotransform"] = joined(*t, format_double, " ");
    const double across = std::hypot((*t)[1], (*t)[4]), down = std::hypot((*t)[2], (*t)[5]);
    // Degrees of longitude and latitude are not alike on the ground.
    if (from.coordinate_system.starts_with("PROJCS") && across > 0.0 && down > 0.0) info.pixel_aspect = across / down;
  }
  if (!from.coordinate_system.empty()) info.attributes["coordinate system"] = from.coordinate_system;
  check_plane_pixels(path, info.width, info.height);
  std::vector<std::string> names;
  for (const GdalBand& band : from.bands) {
    image.planes.push_back({.gain = band.gain, .offset = band.offset, .no_data = band.no_data});
    names.push_back(!band.name.empty()      ? band.name
                    : from.bands.size() > 1 ? "band " + std::to_string(names.size() + 1)
                                            : "Y");
  }
  if (const auto& [gain, offset, none] = image.planes.front(); gain != 1.0 || offset != 0.0)
    info.storage += ", scale " + format_double(gain) + " and offset " + format_double(offset) + " applied";
  if (const auto& no_data = from.bands.front().no_data)
    note_no_data(info, format_double(*no_data) + " (as the file states it)");
  name_channels(image, names, part);
  for (ChannelInfo& channel : info.channels) channel.part_name = from.name;
  image.decode = [gdal = &gdal(), path, planes = image.planes, dataset = from.dataset,
                  one_at_a_time = std::make_shared<std::mutex>()](std::int64_t plane, std::int64_t x, std::int64_t y,
                                                                  ImageView<float> out, Rounding* rounding) {
    const std::int64_t rows = strip_rows(out.width, out.height);
    std::vector<double> strip(static_cast<std::size_t>(rows * out.width));
    for (std::int64_t first = 0; first < out.height; first += rows) {
      const std::int64_t count = std::min(rows, out.height - first);
      {
        const std::scoped_lock lock(*one_at_a_time);
        gdal->read(dataset.get(), path, static_cast<int>(plane), x, y + first, out.width, count, strip.data());
      }
      for (std::int64_t row = 0; row < count; ++row)
        to_floats({.kind = 'f', .bytes = 8, .big_endian = std::endian::native == std::endian::big},
                  reinterpret_cast<const char*>(strip.data() + row * out.width), sizeof(double),
                  planes[static_cast<std::size_t>(plane)], {out.row(first + row), static_cast<std::size_t>(out.width)},
                  rounding);
    }
  };
  return image;
}

}  // namespace

std::vector<RawImage> open_gdal(const std::string& path, Part part) {
  std::vector<RawImage> images;
  for (auto& [number, image] : gdal().open(path, part)) images.push_back(image_of(path, std::move(image), number));
  return images;
}

}  // namespace mtf::io
