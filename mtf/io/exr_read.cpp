// SPDX-License-Identifier: Apache-2.0
#include "mtf/io/exr_read.h"

#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfInputPart.h>
#include <OpenEXR/ImfMultiPartInputFile.h>
#include <OpenEXR/ImfPartType.h>
#include <OpenEXR/ImfTiledInputPart.h>

#include <algorithm>
#include <cstdint>
#include <exception>
#include <new>
#include <optional>
#include <utility>

#include "mtf/error.h"
#include "mtf/io/channel_choice.h"
#include "mtf/io/exr_info.h"
#include "mtf/io/exr_scan.h"
#include "mtf/io/file_checks.h"

namespace mtf::io {
namespace {

struct Window {
  std::int64_t x0, y0, x1, y1;
  std::int64_t width() const { return x1 - x0 + 1; }
  std::int64_t height() const { return y1 - y0 + 1; }
};

Window window_of(const Imath::Box2i& box) { return {box.min.x, box.min.y, box.max.x, box.max.y}; }

// Runs `action` and turns what the library throws into our errors.
template <class Action>
auto guarded(const std::string& path, Action&& action) {
  try {
    return std::forward<Action>(action)();
  } catch (const Error&) {
    throw;
  } catch (const std::bad_alloc&) {
    throw RuntimeError("cannot read " + path + ": out of memory; crop the image or choose one channel");
  } catch (const std::exception& error) {
    std::string why = error.what();
    const auto named = why.find(path + "\". ");  // the library names the file too
    if (named != std::string::npos) why.erase(0, named + path.size() + 3);
    throw RuntimeError("cannot read " + path + ": damaged or incomplete OpenEXR file (" + printable(why) +
                       "); copy or export the file again");
  }
}

// Broken chunk tables are not rebuilt: a file that is only partly there is refused.
constexpr bool rebuild_tables = false;

// A float frame buffer over `planes` whose pixel (x0, y0) is the first sample of each plane.
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

// One part opened for pixels, scan lines and tiles behind the same call.
class PixelSource {
 public:
  PixelSource(Imf::MultiPartInputFile& file, int part) {
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

  /// Rows that are decoded together; bands start at the first row of the data window.
  std::int64_t band_rows() const { return band_; }

  void read(const Imf::FrameBuffer& buffer, std::int64_t first, std::int64_t last) {
    if (lines_) {
      lines_->setFrameBuffer(buffer);
      lines_->readPixels(static_cast<int>(first), static_cast<int>(last));
      return;
    }
    tiled_->setFrameBuffer(buffer);
    const int row = static_cast<int>((first - top_) / band_);
    tiled_->readTiles(0, tiled_->numXTiles(0) - 1, row, row, 0, 0);
  }

 private:
  std::optional<Imf::InputPart> lines_;
  std::optional<Imf::TiledInputPart> tiled_;
  std::int64_t band_ = 1;
  std::int64_t top_ = 0;
};

// Copies the part of a decoded band that lies in the display window.
void copy_band(const float* band, const Window& data, std::int64_t first, std::int64_t last, const Window& display,
               Image& plane) {
  const std::int64_t x0 = std::max(data.x0, display.x0), x1 = std::min(data.x1, display.x1);
  if (x0 > x1) return;
  for (std::int64_t y = std::max(first, display.y0); y <= std::min(last, display.y1); ++y) {
    const float* from = band + (y - first) * data.width() + (x0 - data.x0);
    std::copy(from, from + (x1 - x0 + 1), plane.view().row(y - display.y0) + (x0 - display.x0));
  }
}

// Zeros where the data window does not reach. After decoding: damaged files fail before this memory is touched.
void clear_outside(const Window& data, const Window& display, Image& plane) {
  for (std::int64_t y = display.y0; y <= display.y1; ++y) {
    float* row = plane.view().row(y - display.y0);
    const bool covered = y >= data.y0 && y <= data.y1;
    const std::int64_t left =
        covered ? std::clamp(data.x0 - display.x0, std::int64_t{0}, plane.width()) : plane.width();
    const std::int64_t right = covered ? std::clamp(data.x1 + 1 - display.x0, left, plane.width()) : plane.width();
    std::fill(row, row + left, 0.0F);
    std::fill(row + right, row + plane.width(), 0.0F);
  }
}

void decode(PixelSource& source, const Window& data, const Window& display, const std::vector<std::string>& channels,
            std::vector<Image>& planes) {
  const bool inside = data.x0 >= display.x0 && data.x1 <= display.x1;
  std::vector<float*> direct;
  for (Image& plane : planes) direct.push_back(plane.data());
  const Imf::FrameBuffer whole = frame_buffer(channels, direct, display.x0, display.y0, display.width());

  std::vector<AlignedBuffer<float>> scratch;
  const std::int64_t rows = std::min(source.band_rows(), data.height());
  for (std::int64_t first = data.y0; first <= data.y1; first += source.band_rows()) {
    const std::int64_t last = std::min(first + source.band_rows() - 1, data.y1);
    if (inside && first >= display.y0 && last <= display.y1) {
      source.read(whole, first, last);
      continue;
    }
    std::vector<float*> bands;
    if (scratch.empty())
      for (std::size_t i = 0; i < channels.size(); ++i)
        scratch.emplace_back(static_cast<std::size_t>(data.width() * rows));
    for (const AlignedBuffer<float>& band : scratch) bands.push_back(band.data());
    source.read(frame_buffer(channels, bands, data.x0, first, data.width()), first, last);
    for (std::size_t i = 0; i < planes.size(); ++i) copy_band(bands[i], data, first, last, display, planes[i]);
  }
}

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

}  // namespace

FileInfo read_exr_info(const std::string& path) {
  scan_exr_header(path);
  return guarded(path, [&] {
    const Imf::MultiPartInputFile file(path.c_str(), Imf::globalThreadCount(), rebuild_tables);
    return describe_exr(file);
  });
}

ImageFile read_exr(const std::string& path, const ReadOptions& options) {
  scan_exr_header(path);
  return guarded(path, [&] {
    Imf::MultiPartInputFile file(path.c_str(), Imf::globalThreadCount(), rebuild_tables);
    ImageFile image;
    image.info = describe_exr(file);
    const ChannelChoice choice = choose_channels(path, image.info.channels, options);
    const int part = image.info.channels[choice.indices[0]].part;
    const Imf::Header& header = file.header(part);
    if (header.hasType() && header.type() != Imf::SCANLINEIMAGE && header.type() != Imf::TILEDIMAGE)
      throw RuntimeError(path + ": part " + std::to_string(part) + " is of unknown type '" + printable(header.type()) +
                         "'; export it as a scan-line or tiled image");
    if (!file.partComplete(part))
      throw RuntimeError("cannot read " + path + ": part " + std::to_string(part) +
                         " is incomplete: scan lines or tiles are missing (a render that was stopped?); "
                         "render or copy the file again");

    const Window data = window_of(header.dataWindow()), display = window_of(header.displayWindow());
    image.info.data_window = {header.dataWindow().min.x, header.dataWindow().min.y, header.dataWindow().max.x,
                              header.dataWindow().max.y};
    const auto count = static_cast<std::int64_t>(choice.indices.size());
    check_plane_size(path, data.width(), data.height(), count);
    check_plane_size(path, display.width(), display.height(), count);
    check_display_window(path, data, display);

    std::vector<std::string> channels;
    for (const std::size_t i : choice.indices) {
      channels.push_back(image.info.channels[i].name);
      image.integer = image.integer || image.info.channels[i].type == "uint";
    }
    PixelSource source(file, part);
    for (std::size_t i = 0; i < channels.size(); ++i) image.planes.emplace_back(display.width(), display.height());
    decode(source, data, display, channels, image.planes);
    for (Image& plane : image.planes) clear_outside(data, display, plane);
    image.names = choice.names;
    image.missing_pixels = display.width() * display.height() - overlap(data, display);
    return image;
  });
}

}  // namespace mtf::io
