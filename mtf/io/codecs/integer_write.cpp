// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <limits>

#include "mtf/error.h"
#include "mtf/io/atomic_file.h"
#include "mtf/io/codecs/codecs.h"
#include "mtf/io/codecs/drawing.h"
#include "mtf/io/csv/csv_cells.h"
#include "mtf/io/file_checks.h"
#include "mtf/io/image_io.h"
#include "mtf/io/plane_checks.h"
#include "mtf/words.h"

namespace mtf::io {
namespace {

// round((value - offset) / gain) clamped to 0..scaling.largest(), colours interleaved; counts the clamped (NaN too).
RasterData quantise(const std::vector<NamedPlane>& planes, const IntegerScaling& scaling, std::int64_t& clamped) {
  const ImageView<const float>& first = planes[0].plane;
  const double highest = scaling.largest();
  RasterData data;
  data.width = first.width;
  data.height = first.height;
  data.colours = static_cast<int>(planes.size());
  data.bits = scaling.bits;
  data.samples.resize(static_cast<std::size_t>(first.width * first.height * data.colours));
  for (int c = 0; c < data.colours; ++c) {
    std::uint16_t* to = data.samples.data() + c;
    for (std::int64_t y = 0; y < first.height; ++y) {
      const float* row = planes[static_cast<std::size_t>(c)].plane.row(y);
      for (std::int64_t x = 0; x < first.width; ++x, to += data.colours) {
        const double count = std::round((static_cast<double>(row[x]) - scaling.offset) / scaling.gain);
        const bool inside = count >= 0 && count <= highest;
        clamped += inside ? 0 : 1;
        *to = static_cast<std::uint16_t>(inside ? count : (count > highest ? highest : 0));
      }
    }
  }
  return data;
}

void write_raster(const std::string& path, Format format, const RasterData& data) {
  const Codecs& module = codecs();
  AtomicFile file(path);
  file.check(format == Format::png ? module.encode_png(file.descriptor(), data)
                                   : module.encode_tiff(file.descriptor(), data));
  file.commit();
}

void check_colours(const std::string& path, const std::vector<NamedPlane>& planes) {
  check_planes(path, planes);
  constexpr std::int64_t max_side = 1 << 20;  // what readers accept, ours included
  const ImageView<const float>& first = planes[0].plane;
  if (planes.size() != 1 && planes.size() != 3)
    throw UsageError(path + ": PNG and TIFF take 1 or 3 planes, not " + std::to_string(planes.size()) +
                     "; choose one channel or write OpenEXR");
  if (first.width > max_side || first.height > max_side || first.width * first.height > max_plane_pixels / 2)
    throw UsageError(path + ": PNG and TIFF are limited to 2^30 pixels and 2^20 a side; write OpenEXR");
}

std::pair<double, double> finite_range(const std::vector<NamedPlane>& planes) {
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (const NamedPlane& plane : planes) {
    for (std::int64_t y = 0; y < plane.plane.height; ++y) {
      const float* row = plane.plane.row(y);
      for (std::int64_t x = 0; x < plane.plane.width; ++x) {
        if (!std::isfinite(row[x])) continue;
        low = std::min(low, static_cast<double>(row[x]));
        high = std::max(high, static_cast<double>(row[x]));
      }
    }
  }
  return {low, high};
}

RasterData preview(const std::string& path, const std::vector<NamedPlane>& planes, double low, double high) {
  if (format_from_extension(path) != Format::png) throw UsageError(path + ": previews are PNG; end the name in .png");
  if (!std::isfinite(low) || !std::isfinite(high))
    throw UsageError(path + ": the display range must be two finite numbers");
  check_colours(path, planes);
  std::int64_t clamped = 0;
  return quantise(planes, {.gain = high != low ? (high - low) / 255.0 : 1.0, .offset = low, .bits = 8}, clamped);
}

}  // namespace

void check_planes(const std::string& path, const std::vector<NamedPlane>& planes) {
  if (planes.empty()) throw UsageError("cannot write " + path + ": there is no plane to write; choose a channel");
  const ImageView<const float>& first = planes[0].plane;
  for (const NamedPlane& plane : planes)
    if (plane.plane.width != first.width || plane.plane.height != first.height)
      throw UsageError("cannot write " + path + ": plane '" + printable(plane.name, 40) + "' has " +
                       std::to_string(plane.plane.width) + " x " + std::to_string(plane.plane.height) +
                       " pixels, the first one " + std::to_string(first.width) + " x " + std::to_string(first.height) +
                       "; write planes of one size");
  constexpr std::int64_t max_side = std::int64_t{1} << 30;
  if (first.width < 1 || first.height < 1 || first.width > max_side || first.height > max_side ||
      first.width * first.height > max_plane_pixels)
    throw UsageError("cannot write " + path + ": " + std::to_string(first.width) + " x " +
                     std::to_string(first.height) + " pixels; an image has at least 1 and at most 2^31 pixels");
}

IntegerScaling full_range_scaling(const std::vector<NamedPlane>& planes) {
  const auto [low, high] = finite_range(planes);
  if (!(low <= high)) return {};
  return {.gain = low < high ? (high - low) / 65535.0 : 1.0, .offset = low};
}

std::int64_t write_integer(const std::string& path, const std::vector<NamedPlane>& planes,
                           const IntegerScaling& scaling, const Metadata& metadata) {
  const Format format = format_from_extension(path);
  if (format == Format::exr) throw UsageError(path + ": integers go to .png, .tif or .tiff; OpenEXR keeps floats");
  if (!std::isfinite(scaling.gain) || scaling.gain == 0 || !std::isfinite(scaling.offset))
    throw UsageError(path + ": the scaling needs a finite offset and a finite gain other than 0");
  if (scaling.bits != 8 && scaling.bits != 16) throw UsageError(path + ": integers are of 8 or 16 bits");
  check_colours(path, planes);
  std::int64_t clamped = 0;
  RasterData data = quantise(planes, scaling, clamped);
  data.text = words_of(metadata);
  data.text.insert(data.text.begin(), {{"gain", number_text(scaling.gain)}, {"offset", number_text(scaling.offset)}});
  write_raster(path, format, data);
  return clamped;
}

void write_preview_png(const std::string& path, const std::vector<NamedPlane>& planes, double low, double high) {
  write_raster(path, Format::png, preview(path, planes, low, high));
}

void write_annotated_png(const std::string& path, ImageView<const float> plane, double low, double high,
                         const Drawing& drawing) {
  constexpr std::int64_t max_pixels = std::int64_t{1} << 28;
  const std::int64_t area = static_cast<std::int64_t>(drawing.zoom) * drawing.zoom;
  if (drawing.zoom < 1 || drawing.zoom > 16 || plane.width * plane.height > max_pixels / area)
    throw UsageError(path + ": " + std::to_string(plane.width) + " x " + std::to_string(plane.height) +
                     " pixels are too many to draw upon; choose a region");
  const std::vector<NamedPlane> grey(3, NamedPlane{"", plane});
  write_raster(path, Format::png, drawn(preview(path, grey, low, high), drawing));
}

}  // namespace mtf::io
