// SPDX-License-Identifier: Apache-2.0
// The table of the module and what its formats share; JPEG and JPEG-LS, which are one call.

#ifdef MTFKIT_HAVE_CHARLS
#include <charls/charls.h>
#endif
#include <turbojpeg.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <limits>
#include <memory>

#include "mtf/error.h"
#include "mtf/io/codecs/codecs_parts.h"
#include "mtf/io/codecs/raster_scan.h"
#include "mtf/version.h"
#include "mtf/words.h"

namespace mtf::io::module {
namespace {

template <class T>
void place_samples(const Piece& piece, const RasterHeader& header, std::vector<Image>& planes) {
  for (std::size_t c = 0; c < planes.size(); ++c) {
    const std::int64_t width = std::min(piece.width, planes[c].width() - piece.x);
    const std::int64_t height = std::min(piece.height, planes[c].height() - piece.y);
    for (std::int64_t y = 0; y < height; ++y) {
      const T* from = static_cast<const T*>(piece.samples) + y * piece.row_samples + static_cast<std::int64_t>(c);
      float* to = planes[c].view().row(piece.y + y) + piece.x;
      for (std::int64_t x = 0; x < width; ++x) to[x] = static_cast<float>(from[x * piece.pixel_samples]);
      if constexpr (std::is_same_v<T, double>)
        for (std::int64_t x = 0; x < width; ++x)
          if (!header.no_data || to[x] != header.no_data->value)
            piece.rounding[c].add(from[x * piece.pixel_samples], to[x]);
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
  if (header.type == "uint8") return place_samples<std::uint8_t>(piece, header, planes);
  if (header.type == "uint16") return place_samples<std::uint16_t>(piece, header, planes);
  if (header.type == "int8") return place_samples<std::int8_t>(piece, header, planes);
  if (header.type == "int16") return place_samples<std::int16_t>(piece, header, planes);
  if (header.type == "double") return place_samples<double>(piece, header, planes);
  place_samples<float>(piece, header, planes);
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

int write_all(int descriptor, const void* data, std::size_t size) {
  const char* bytes = static_cast<const char*>(data);
  while (size > 0) {
    const ssize_t written = ::write(descriptor, bytes, size);
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) return errno;
    if (written == 0) return ENOSPC;
    bytes += written;
    size -= static_cast<std::size_t>(written);
  }
  return 0;
}

void undecodable(const std::string& path, const std::string& format, const std::string& why) {
  throw RuntimeError("cannot read " + path + ": damaged, incomplete or unsupported " + format + " file" +
                     (why.empty() ? "" : " (" + printable(why) + ")") + "; copy or export the file again");
}

// The luminance plane as it is stored. Of damaged data libjpeg makes some image, with a warning: here that is an error.
std::vector<Image> decode_jpeg(const std::string& path, const RasterHeader& header) {
  std::vector<unsigned char> file;
  require_same(scan_jpeg(path, &file), header, path, "JPEG");
  const std::unique_ptr<void, int (*)(tjhandle)> decoder(tjInitDecompress(), &tjDestroy);
  std::vector<unsigned char> pixels(static_cast<std::size_t>(header.width * header.height));
  const int width = static_cast<int>(header.width), height = static_cast<int>(header.height);
  if (tjDecompress2(decoder.get(), file.data(), file.size(), pixels.data(), width, width, height, TJPF_GRAY,
                    TJFLAG_STOPONWARNING | TJFLAG_ACCURATEDCT) != 0)
    undecodable(path, "JPEG", tjGetErrorStr2(decoder.get()));
  std::vector<Image> planes = empty_planes(header);
  place({pixels.data(), 0, 0, header.width, header.height, header.width, 1}, header, planes);
  return planes;
}

#ifdef MTFKIT_HAVE_CHARLS
std::vector<char> decode_jpeg_ls(const std::string& path, const std::string& bytes, std::int64_t width,
                                 std::int64_t height) try {
  charls::jpegls_decoder decoder(bytes, true);
  const charls::frame_info& frame = decoder.frame_info();
  if (frame.width != width || frame.height != height || frame.component_count != 1 || frame.bits_per_sample <= 8)
    undecodable(path, "JPEG-LS", "its pixels are not those that are announced, of 9 to 16 bits");
  std::vector<char> counts(static_cast<std::size_t>(2 * width * height));
  decoder.decode(counts);
  return counts;
} catch (const charls::jpegls_error& error) {
  undecodable(path, "JPEG-LS", error.what());
}
#else
constexpr std::nullptr_t decode_jpeg_ls = nullptr;
#endif

}  // namespace mtf::io::module

extern "C" __attribute__((visibility("default"))) const void* mtfkit_codecs_table() {
  namespace module = mtf::io::module;
  static const mtf::io::Codecs table{{mtf::version, mtf::git_commit},
                                     module::tiff_header,
                                     module::decode_png,
                                     module::decode_tiff,
                                     module::decode_jpeg,
                                     module::decode_jpeg_ls,
                                     module::encode_png,
                                     module::encode_tiff};
  module::silence_tiff();
  return &table;
}
