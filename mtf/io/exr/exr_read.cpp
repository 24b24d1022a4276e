// SPDX-License-Identifier: Apache-2.0
#include "mtf/io/exr/exr_read.h"

#include <algorithm>
#include <cstdint>

#include "mtf/io/exr/exr_info.h"
#include "mtf/io/exr/exr_pixels.h"
#include "mtf/io/exr/exr_scan.h"

namespace mtf::io {
namespace {

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

// Zeros outside the data window. After decoding: damaged files fail before this memory is touched.
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

}  // namespace

FileInfo read_exr_info(const std::string& path) {
  scan_exr_header(path);
  return guarded(path, [&] {
    const Imf::MultiPartInputFile file(path.c_str(), Imf::globalThreadCount(), false);
    return describe_exr(file);
  });
}

ImageFile read_exr(const std::string& path, const ReadOptions& options) {
  return guarded(path, [&] {
    OpenedExr opened(path, options);
    const Window &data = opened.data, &display = opened.display;
    const auto count = static_cast<std::int64_t>(opened.channels.size());
    check_plane_size(path, data.width(), data.height(), count);
    check_plane_size(path, display.width(), display.height(), count);
    ImageFile image = std::move(opened.image);
    PixelSource source(opened.file, opened.part);
    for (std::int64_t i = 0; i < count; ++i) image.planes.emplace_back(display.width(), display.height());
    decode(source, data, display, opened.channels, image.planes);
    for (Image& plane : image.planes) clear_outside(data, display, plane);
    return image;
  });
}

}  // namespace mtf::io
