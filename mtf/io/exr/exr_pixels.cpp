// SPDX-License-Identifier: Apache-2.0
#include "mtf/io/exr/exr_pixels.h"

#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfPartType.h>

#include <algorithm>

#include "mtf/io/channel_choice.h"
#include "mtf/io/exr/exr_info.h"
#include "mtf/work/stop.h"

namespace mtf::io {
namespace {

// Broken chunk tables are not rebuilt: a file that is only partly there is refused.
constexpr bool rebuild_tables = false;

Window window_of(const Imath::Box2i& box) { return {box.min.x, box.min.y, box.max.x, box.max.y}; }

std::int64_t overlap(const Window& a, const Window& b) {
  const std::int64_t width = std::min(a.x1, b.x1) - std::max(a.x0, b.x0) + 1;
  const std::int64_t height = std::min(a.y1, b.y1) - std::max(a.y0, b.y0) + 1;
  return width > 0 && height > 0 ? width * height : 0;
}

// A display window is only a claim: one that is huge and nearly empty is a damaged header, or a crop whose frame nobody
// wants filled with zeros.
void check_display_window(const std::string& path, const Window& data, const Window& display) {
  constexpr std::int64_t always_allowed = std::int64_t{1} << 24, sparsest = 256;
  const std::int64_t pixels = display.width() * display.height();
  if (pixels <= always_allowed || pixels / sparsest <= overlap(data, display)) return;
  throw RuntimeError(path + ": the display window of " + std::to_string(display.width()) + " x " +
                     std::to_string(display.height()) + " pixels needs " +
                     shown_bytes(static_cast<double>(pixels) * sizeof(float)) +
                     " a plane, but less than 1/256 of it is in the file; damaged, or set it to the data window");
}

// The header is checked before the library allocates what it asks for.
const char* scanned(const std::string& path) {
  scan_exr_header(path);
  return path.c_str();
}

}  // namespace

Imf::FrameBuffer frame_buffer(const std::vector<std::string>& channels, const std::vector<float*>& planes,
                              std::int64_t x0, std::int64_t y0, std::int64_t stride) {
  Imf::FrameBuffer buffer;
  for (std::size_t i = 0; i < channels.size(); ++i) {
    // The library adds coordinates to a base outside the plane; through integers this is well defined.
    const auto origin = static_cast<std::uintptr_t>((y0 * stride + x0) * std::int64_t{sizeof(float)});
    auto* base = reinterpret_cast<char*>(reinterpret_cast<std::uintptr_t>(planes[i]) - origin);
    buffer.insert(channels[i],
                  Imf::Slice(Imf::FLOAT, base, sizeof(float), static_cast<std::size_t>(stride) * sizeof(float)));
  }
  return buffer;
}

PixelSource::PixelSource(Imf::MultiPartInputFile& file, int part) {
  const Imf::Header& header = file.header(part);
  if (exr_part_tiled(header)) {
    tiled_.emplace(file, part);
    band_ = header.tileDescription().ySize;
  } else {
    lines_.emplace(file, part);
    const int chunk = std::max(exr_chunk_lines(header.compression()), 1);
    band_ = std::max(chunk, 32);
  }
  top_ = header.dataWindow().min.y;
}

void PixelSource::read(const Imf::FrameBuffer& buffer, std::int64_t first, std::int64_t last) {
  require_going_on();
  if (lines_) {
    lines_->setFrameBuffer(buffer);
    lines_->readPixels(static_cast<int>(first), static_cast<int>(last));
    return;
  }
  tiled_->setFrameBuffer(buffer);
  const int row = static_cast<int>((first - top_) / band_);
  tiled_->readTiles(0, tiled_->numXTiles(0) - 1, row, row, 0, 0);
}

OpenedExr::OpenedExr(const std::string& path, const ReadOptions& options)
    : file(scanned(path), Imf::globalThreadCount(), rebuild_tables) {
  image.info = describe_exr(file);
  const ChannelChoice choice = choose_channels(path, image.info.channels, options);
  part = image.info.channels[choice.indices[0]].part;
  image.info = describe_exr(file, part);
  const Imf::Header& header = file.header(part);
  if (header.hasType() && header.type() != Imf::SCANLINEIMAGE && header.type() != Imf::TILEDIMAGE)
    throw RuntimeError(path + ": part " + std::to_string(part) + " is of unknown type '" + printable(header.type()) +
                       "'; export it as a scan-line or tiled image");
  if (!file.partComplete(part))
    throw RuntimeError("cannot read " + path + ": part " + std::to_string(part) +
                       " is incomplete: scan lines or tiles are missing (a render that was stopped?); "
                       "render or copy the file again");
  data = window_of(header.dataWindow());
  display = window_of(header.displayWindow());
  for (const std::size_t i : choice.indices) {
    channels.push_back(image.info.channels[i].name);
    image.integer = image.integer || image.info.channels[i].type == "uint";
  }
  image.names = choice.names;
  check_plane_pixels(path, data.width(), data.height());
  check_plane_pixels(path, display.width(), display.height());
  check_display_window(path, data, display);
  image.missing_pixels = display.width() * display.height() - overlap(data, display);
}

}  // namespace mtf::io
