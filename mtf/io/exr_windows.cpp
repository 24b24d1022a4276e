// SPDX-License-Identifier: Apache-2.0
#include "mtf/io/exr_windows.h"

#include <algorithm>
#include <list>
#include <mutex>

#include "mtf/io/exr_pixels.h"
#include "mtf/io/exr_threads.h"

namespace mtf::io {
namespace {

constexpr std::int64_t kRowsTogether = 128;  // chunks enough for several threads to decode
constexpr std::int64_t kFewestRows = 4 * kRowsTogether;

// Decoded rows of the data window, all channels.
struct Band {
  std::int64_t first = 0, last = -1;  // rows of the file, both included
  std::vector<Image> planes;
};

struct Opened : OpenedExr {
  Opened(const std::string& path, const ReadOptions& options) : OpenedExr(path, options), source(file, part) {}
  PixelSource source;
};

}  // namespace

struct ExrWindows::Impl {
  std::string path;
  std::optional<Opened> exr;
  std::int64_t rows_kept = kFewestRows;
  std::int64_t band_rows = 1;
  mutable std::mutex lock;
  mutable std::list<std::shared_ptr<const Band>> bands;  // the one used last in front

  // The band that holds a row of the file, decoded now if need be.
  std::shared_ptr<const Band> band_of(std::int64_t row) const {
    const std::scoped_lock guard(lock);
    for (auto it = bands.begin(); it != bands.end(); ++it)
      if (row >= (*it)->first && row <= (*it)->last) {
        bands.splice(bands.begin(), bands, it);
        return bands.front();
      }
    while (!bands.empty() && static_cast<std::int64_t>(bands.size() + 1) * band_rows > rows_kept) bands.pop_back();
    auto band = std::make_shared<Band>();
    band->first = exr->data.y0 + (row - exr->data.y0) / band_rows * band_rows;
    band->last = std::min(band->first + band_rows - 1, exr->data.y1);
    guarded(path, [&] { decode(*band); });
    bands.push_front(std::move(band));
    return bands.front();
  }

  void decode(Band& band) const {
    std::vector<float*> planes;
    for (std::size_t i = 0; i < exr->channels.size(); ++i)
      planes.push_back(band.planes.emplace_back(exr->data.width(), band.last - band.first + 1).data());
    const Imf::FrameBuffer buffer = frame_buffer(exr->channels, planes, exr->data.x0, band.first, exr->data.width());
    auto& source = const_cast<PixelSource&>(exr->source);  // reading moves only the library's own state, locked here
    // Tiles come a row of them at a time, scan lines all at once.
    const std::int64_t step = source.tiled() ? source.band_rows() : band_rows;
    for (std::int64_t first = band.first; first <= band.last; first += step)
      source.read(buffer, first, std::min(first + step - 1, band.last));
  }
};

ExrWindows::ExrWindows(const std::string& path, const ReadOptions& options, int threads)
    : impl_(std::make_unique<Impl>()) {
  use_exr_threads(threads);
  impl_->path = path;
  guarded(path, [&] { impl_->exr.emplace(path, options); });
  const std::int64_t together = impl_->exr->source.band_rows();
  impl_->band_rows = std::max<std::int64_t>(1, kRowsTogether / together) * together;
}

ExrWindows::~ExrWindows() = default;

const ImageFile& ExrWindows::file() const { return impl_->exr->image; }

std::int64_t ExrWindows::row_bytes() const {
  return impl_->exr->data.width() * static_cast<std::int64_t>(impl_->exr->channels.size() * sizeof(float));
}

void ExrWindows::keep_rows(std::int64_t rows) { impl_->rows_kept = std::max(rows, kFewestRows); }

void ExrWindows::read(std::size_t channel, std::int64_t x, std::int64_t y, ImageView<float> out) const {
  const Window &data = impl_->exr->data, &display = impl_->exr->display;
  const std::int64_t left = std::clamp<std::int64_t>(data.x0 - display.x0 - x, 0, out.width);
  const std::int64_t right = std::clamp<std::int64_t>(data.x1 + 1 - display.x0 - x, left, out.width);
  std::shared_ptr<const Band> band;
  for (std::int64_t j = 0; j < out.height; ++j) {
    const std::int64_t row = display.y0 + y + j;
    float* to = out.row(j);
    if (row < data.y0 || row > data.y1 || right == left) {
      std::fill_n(to, out.width, 0.0F);
      continue;
    }
    if (!band || row > band->last) band = impl_->band_of(row);
    const Image& plane = band->planes[channel];
    const float* from = plane.view().row(row - band->first) + (display.x0 + x + left - data.x0);
    std::fill_n(to, left, 0.0F);
    std::copy_n(from, right - left, to + left);
    std::fill_n(to + right, out.width - right, 0.0F);
  }
}

}  // namespace mtf::io
