// SPDX-License-Identifier: Apache-2.0
#include "mtf/io/exr/exr_read.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <mutex>

#include "mtf/io/exr/band_cache.h"
#include "mtf/io/exr/exr_open.h"
#include "mtf/io/raw/number_type.h"

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
            std::vector<Image>& planes, bool whole_numbers) {
  const bool inside = data.x0 >= display.x0 && data.x1 <= display.x1;
  std::vector<float*> direct;
  for (Image& plane : planes) direct.push_back(plane.data());
  const Imf::FrameBuffer whole = frame_buffer(channels, direct, display.x0, display.y0, display.width(), whole_numbers);

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
    source.read(frame_buffer(channels, bands, data.x0, first, data.width(), whole_numbers), first, last);
    for (std::size_t i = 0; i < planes.size(); ++i) copy_band(bands[i], data, first, last, display, planes[i]);
  }
}

/// The bits of uint32 in place of floats become the floats.
void convert_whole_numbers(const std::string& path, const std::string& name, Image& plane,
                           std::vector<std::string>& notes) {
  const auto* bytes = reinterpret_cast<const char*>(plane.data());
  Rounding rounding;
  to_floats({.kind = 'u', .bytes = 4, .big_endian = false}, bytes, sizeof(float), {},
            {plane.data(), static_cast<std::size_t>(plane.size())}, &rounding);
  rounding.note(path, name, notes);
}

constexpr std::int64_t kRowsTogether = 32, kBytesTogether = 256 << 10;  // of a band, at least

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
    decode(source, data, display, opened.channels, image.planes, opened.whole_numbers);
    for (std::size_t i = 0; i < image.planes.size(); ++i) {
      clear_outside(data, display, image.planes[i]);
      if (opened.whole_numbers) convert_whole_numbers(path, image.names[i], image.planes[i], image.info.notes);
    }
    return image;
  });
}

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
  if (impl_->exr->image.integer)
    impl_->exr->image.info.notes.emplace_back("whole numbers above 2^24 are rounded to float32");
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
