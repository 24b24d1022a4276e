// SPDX-License-Identifier: Apache-2.0
#include "mtf/io/exr/exr_windows.h"

#include <algorithm>
#include <array>
#include <mutex>

#include "mtf/io/exr/band_cache.h"
#include "mtf/io/exr/exr_pixels.h"

namespace mtf::io {
namespace {

constexpr std::int64_t kRowsTogether = 32, kBytesTogether = 256 << 10;  // of a band, at least

}  // namespace

// The library decodes one call at a time for each open file: every thread that decodes has a file of its own.
struct ExrWindows::Impl {
  struct Opened : OpenedExr {
    Opened(const std::string& path, const ReadOptions& options) : OpenedExr(path, options), source(file, part) {}
    PixelSource source;
  };

  std::string path;
  ReadOptions options;
  std::unique_ptr<Opened> exr;
  std::int64_t band_rows = 1;
  std::mutex lock;
  std::vector<std::unique_ptr<Opened>> idle;
  std::optional<BandCache> bands;

  static bool same_layout(const Opened& a, const Opened& b) {
    const auto window = [](const Window& w) { return std::array{w.x0, w.y0, w.x1, w.y1}; };
    return window(a.data) == window(b.data) && a.channels == b.channels && a.part == b.part &&
           a.source.tiled() == b.source.tiled() && a.source.band_rows() == b.source.band_rows();
  }

  std::unique_ptr<Opened> take() {
    {
      const std::scoped_lock guard(lock);
      if (!idle.empty()) {
        std::unique_ptr<Opened> file = std::move(idle.back());
        idle.pop_back();
        return file;
      }
    }
    auto file = std::make_unique<Opened>(path, options);
    if (!same_layout(*file, *exr))
      throw RuntimeError("cannot read " + path + ": another file has taken its place; run the command again");
    return file;
  }

  std::int64_t band_of(std::int64_t row) const { return (row - exr->data.y0) / band_rows; }
  std::int64_t first_row(std::int64_t band) const { return exr->data.y0 + band * band_rows; }

  // What fails is not used again: its state is unknown.
  void decode(std::int64_t index, Band& band) {
    std::unique_ptr<Opened> file = take();
    const std::int64_t first = first_row(index), last = std::min(first + band_rows - 1, exr->data.y1);
    std::vector<float*> planes;
    for (std::size_t i = 0; i < exr->channels.size(); ++i)
      planes.push_back((i < band.size() ? band[i] : band.emplace_back(exr->data.width(), band_rows)).data());
    const Imf::FrameBuffer buffer = frame_buffer(exr->channels, planes, exr->data.x0, first, exr->data.width());
    // Tiles come a row of them at a time, scan lines all at once.
    const std::int64_t step = file->source.tiled() ? file->source.band_rows() : band_rows;
    for (std::int64_t row = first; row <= last; row += step)
      file->source.read(buffer, row, std::min(row + step - 1, last));
    const std::scoped_lock guard(lock);
    idle.push_back(std::move(file));
  }
};

ExrWindows::ExrWindows(const std::string& path, const ReadOptions& options) : impl_(std::make_unique<Impl>()) {
  impl_->path = path;
  impl_->options = options;
  guarded(path, [&] { impl_->exr = std::make_unique<Impl::Opened>(path, options); });
  const std::int64_t together = impl_->exr->source.band_rows();
  const std::int64_t wanted = std::max(kRowsTogether, kBytesTogether / row_bytes());
  impl_->band_rows = std::max<std::int64_t>(1, wanted / together) * together;
  impl_->bands.emplace(impl_->band_of(impl_->exr->data.y1) + 1, 1,
                       [impl = impl_.get()](std::int64_t index, Band& band) {
                         guarded(impl->path, [&] { impl->decode(index, band); });
                       });
}

ExrWindows::~ExrWindows() = default;

const ImageFile& ExrWindows::file() const { return impl_->exr->image; }

std::int64_t ExrWindows::row_bytes() const {
  return impl_->exr->data.width() * static_cast<std::int64_t>(impl_->exr->channels.size() * sizeof(float));
}

void ExrWindows::keep_rows(std::int64_t rows) {
  // Bands that so many rows may touch.
  impl_->bands->keep((std::max<std::int64_t>(rows, 1) + impl_->band_rows - 2) / impl_->band_rows + 1);
}

std::int64_t ExrWindows::more_rows() const { return 2 * impl_->band_rows; }

void ExrWindows::read(std::size_t channel, std::int64_t x, std::int64_t y, ImageView<float> out) const {
  const Window &data = impl_->exr->data, &display = impl_->exr->display;
  const std::int64_t left = std::clamp<std::int64_t>(data.x0 - display.x0 - x, 0, out.width);
  const std::int64_t right = std::clamp<std::int64_t>(data.x1 + 1 - display.x0 - x, left, out.width);
  const std::int64_t row = display.y0 + y;  // of the file, that of the first of `out`
  const std::int64_t top = right == left ? out.height : std::clamp<std::int64_t>(data.y0 - row, 0, out.height);
  const std::int64_t bottom = std::clamp<std::int64_t>(data.y1 + 1 - row, top, out.height);
  for (std::int64_t j = 0; j < out.height; ++j)
    if (j < top || j >= bottom) std::fill_n(out.row(j), out.width, 0.0F);
  // As many rows at a time as stay decoded.
  for (std::int64_t j = top; j < bottom;) {
    const std::int64_t first = impl_->band_of(row + j);
    const std::int64_t last = std::min(impl_->band_of(row + bottom - 1), first + impl_->bands->kept() - 1);
    const BandCache::Pinned pinned(*impl_->bands, first, last);
    for (; j < bottom && row + j < impl_->first_row(last + 1); ++j) {
      const std::int64_t band = impl_->band_of(row + j);
      const float* from = pinned[band][channel].view().row(row + j - impl_->first_row(band));
      float* to = out.row(j);
      std::fill_n(to, left, 0.0F);
      std::copy_n(from + (display.x0 + x + left - data.x0), right - left, to + left);
      std::fill_n(to + right, out.width - right, 0.0F);
    }
  }
}

}  // namespace mtf::io
