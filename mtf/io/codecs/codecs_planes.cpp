// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <limits>

#include "mtf/error.h"
#include "mtf/io/codecs/codecs_parts.h"
#include "mtf/words.h"

namespace mtf::io::module {
namespace {

template <class T>
void place_samples(const Piece& piece, std::vector<Image>& planes) {
  for (std::size_t c = 0; c < planes.size(); ++c) {
    const std::int64_t width = std::min(piece.width, planes[c].width() - piece.x);
    const std::int64_t height = std::min(piece.height, planes[c].height() - piece.y);
    for (std::int64_t y = 0; y < height; ++y) {
      const T* from = static_cast<const T*>(piece.samples) + y * piece.row_samples + static_cast<std::int64_t>(c);
      float* to = planes[c].view().row(piece.y + y) + piece.x;
      for (std::int64_t x = 0; x < width; ++x) to[x] = static_cast<float>(from[x * piece.pixel_samples]);
    }
  }
}

}  // namespace

std::vector<Image> empty_planes(const RasterHeader& header) {
  std::vector<Image> planes;
  for (int c = 0; c < header.colours; ++c) planes.emplace_back(header.width, header.height);
  return planes;
}

void place(const Piece& piece, const RasterHeader& header, std::vector<Image>& planes) {
  if (header.type == "uint8") return place_samples<std::uint8_t>(piece, planes);
  if (header.type == "uint16") return place_samples<std::uint16_t>(piece, planes);
  if (header.type == "double") return place_samples<double>(piece, planes);
  place_samples<float>(piece, planes);
}

void mark_no_data(const RasterHeader& header, std::vector<Image>& planes) {
  if (!header.no_data) return;
  for (Image& plane : planes)
    std::replace(plane.data(), plane.data() + plane.size(), header.no_data->value,
                 std::numeric_limits<float>::quiet_NaN());
}

void require_same(const RasterHeader& now, const RasterHeader& header, const std::string& path,
                  const std::string& format) {
  if (now.width != header.width || now.height != header.height || now.colours != header.colours ||
      now.type != header.type)
    undecodable(path, format, "pixels do not match the header");
}

void undecodable(const std::string& path, const std::string& format, const std::string& why) {
  throw RuntimeError("cannot read " + path + ": damaged, incomplete or unsupported " + format + " file" +
                     (why.empty() ? "" : " (" + printable(why) + ")") + "; copy or export the file again");
}

}  // namespace mtf::io::module
