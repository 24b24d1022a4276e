// SPDX-License-Identifier: Apache-2.0
#include "mtf/io/exr/exr_scan.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <fstream>
#include <limits>
#include <optional>
#include <vector>

#include "mtf/error.h"
#include "mtf/io/file_checks.h"
#include "mtf/words.h"

namespace mtf::io {
namespace {

constexpr std::uint32_t flag_tiled = 0x200, flag_deep = 0x800, flag_parts = 0x1000;

// Deflate compresses up to 1032:1, PXR24 4/3 of it, run lengths under PIZ 410:1; DWA deflates run lengths.
constexpr double highest_ratio = 2048, highest_ratio_dwa = 262144;
// Buffers below this are allowed whatever the file size: a small image may use large tiles.
constexpr double harmless_bytes = 64.0 * 1024 * 1024;

struct Part {
  std::optional<Window> data, display;
  std::optional<int> compression;
  std::int64_t tile_width = 0, tile_height = 0;
  double pixel_bytes = 0;  // of all channels, subsampling taken into account
  bool has_channels = false;
  bool tiled = false, deep = false;
  std::string type;
};

class Scanner {
 public:
  explicit Scanner(const std::string& path) : path_(path), size_(input_file_size(path)), file_(path, std::ios::binary) {
    if (!file_) throw RuntimeError("cannot read " + path + ": it cannot be opened; check its permissions");
  }

  void run() {
    std::array<std::uint32_t, 2> start{};  // magic number and version; the format is little-endian, as we are
    read(start.data(), sizeof start);
    const std::uint32_t version = start[1];
    if ((version & 0xffU) != 2) damaged("unknown file version " + std::to_string(version & 0xffU));
    const bool multi_part = (version & flag_parts) != 0;
    std::vector<Part> parts;
    do {
      Part part;
      if (!read_part(part)) break;
      part.tiled = part.type.empty() ? (version & flag_tiled) != 0 : part.type.starts_with("tiled");
      part.deep = part.type.starts_with("deep") || (part.type.empty() && (version & flag_deep) != 0);
      parts.push_back(part);
    } while (multi_part);
    if (parts.empty()) damaged("it has no image part");
    for (const Part& part : parts) check(part);
  }

 private:
  [[noreturn]] void damaged(const std::string& why) const {
    throw RuntimeError("cannot read " + path_ + ": damaged or incomplete OpenEXR file (" + why +
                       "); copy or export the file again");
  }

  void read(void* to, std::size_t size) {
    file_.read(static_cast<char*>(to), static_cast<std::streamsize>(size));
    if (!file_) damaged("it ends in the header");
    position_ += static_cast<std::int64_t>(size);
  }

  std::string read_name() {
    std::string name;
    for (char c = 0; read(&c, 1), c != 0;) {
      name += c;
      if (name.size() > 255) damaged("a name in the header has more than 255 characters");
    }
    return name;
  }

  // False when the header is empty: the end of the list of parts.
  bool read_part(Part& part) {
    bool any = false;
    for (std::string name; !(name = read_name()).empty(); any = true) {
      const std::string type = read_name();
      std::int32_t size = 0;
      read(&size, sizeof size);
      if (size < 0 || size > size_ - position_)
        damaged("attribute '" + printable(name, 40) + "' is longer than the file");
      read_attribute(part, name, type, size);
    }
    return any;
  }

  void read_attribute(Part& part, const std::string& name, const std::string& type, std::int32_t size) {
    const bool wanted = name == "channels" || name == "dataWindow" || name == "displayWindow" || name == "tiles" ||
                        name == "compression" || name == "type" || type == "stringvector" || type == "preview";
    if (!wanted) {
      file_.seekg(size, std::ios::cur);
      position_ += size;
      return;
    }
    std::vector<char> bytes(static_cast<std::size_t>(size));
    read(bytes.data(), bytes.size());
    const auto integer = [&](std::size_t at) {
      std::int32_t value = 0;
      if (at + sizeof value > bytes.size()) damaged("attribute '" + printable(name, 40) + "' is cut short");
      std::memcpy(&value, bytes.data() + at, sizeof value);
      return value;
    };
    if (type == "stringvector") {
      for (std::size_t at = 0; at < bytes.size();) {
        const std::int32_t length = integer(at);
        if (length < 0 || static_cast<std::size_t>(length) > bytes.size() - at - 4)
          damaged("attribute '" + printable(name, 40) + "' is cut short");
        at += 4 + static_cast<std::size_t>(length);
      }
    } else if (type == "preview") {
      const std::int64_t width = integer(0), height = integer(4);
      if (width < 0 || height < 0 || (width > 0 && height > (std::int64_t{size} - 8) / 4 / width))
        damaged("the preview image is cut short");
    } else if (name == "channels") {
      read_channels(part, bytes);
    } else if (name == "dataWindow" || name == "displayWindow") {
      const Window window{integer(0), integer(4), integer(8), integer(12)};
      (name == "dataWindow" ? part.data : part.display) = window;
    } else if (name == "tiles") {
      part.tile_width = static_cast<std::uint32_t>(integer(0));
      part.tile_height = static_cast<std::uint32_t>(integer(4));
    } else if (name == "compression") {
      if (bytes.empty()) damaged("attribute 'compression' is cut short");
      part.compression = static_cast<unsigned char>(bytes[0]);
    } else if (name == "type") {
      part.type.assign(bytes.data(), bytes.size());
    }
  }

  void read_channels(Part& part, const std::vector<char>& bytes) {
    part.has_channels = true;
    for (std::size_t at = 0; at < bytes.size() && bytes[at] != 0;) {
      const auto end = std::find(bytes.begin() + static_cast<std::ptrdiff_t>(at), bytes.end(), '\0');
      at = static_cast<std::size_t>(end - bytes.begin()) + 1;
      if (at + 16 > bytes.size()) damaged("the channel list is cut short");
      std::array<std::int32_t, 4> fields{};  // pixel type, linearity, x and y sampling
      std::memcpy(fields.data(), bytes.data() + at, sizeof fields);
      at += sizeof fields;
      if (fields[0] < 0 || fields[0] > 2) damaged("a channel has an unknown pixel type");
      if (fields[2] < 1 || fields[3] < 1) damaged("a channel has an impossible sampling");
      part.pixel_bytes += (fields[0] == 1 ? 2.0 : 4.0) / fields[2] / fields[3];
    }
  }

  void check(const Part& part) const {
    if (!part.has_channels || !part.data || !part.display || !part.compression)
      damaged("channels, compression or a window is missing in the header");
    // The library computes with int: it wants windows well inside.
    constexpr std::int64_t limit = std::numeric_limits<std::int32_t>::max() / 2;
    for (const Window& w : {*part.data, *part.display}) {
      if (w.x0 > w.x1 || w.y0 > w.y1) damaged("a window in the header is inverted");
      if (std::min(w.x0, w.y0) < -limit || std::max(w.x1, w.y1) > limit || w.width() > limit || w.height() > limit)
        damaged("a window of " + std::to_string(w.width()) + " x " + std::to_string(w.height()) +
                " pixels is beyond the format, it would need " +
                shown_bytes(static_cast<double>(w.width()) * static_cast<double>(w.height()) * sizeof(float)) +
                " a channel");
    }
    const int lines = exr_chunk_lines(*part.compression);
    if (lines == 0) damaged("unknown compression " + std::to_string(*part.compression));
    const auto width = static_cast<double>(part.data->width()), height = static_cast<double>(part.data->height());
    const bool tiled = part.tiled || part.type == "deeptile";
    if (tiled && (part.tile_width < 1 || part.tile_height < 1)) damaged("the tile size is missing or zero");

    const double ratio = *part.compression >= 8 ? highest_ratio_dwa : highest_ratio;
    if (!part.deep) check_compression(path_, width * height * part.pixel_bytes, size_, ratio);
    const double chunks = tiled ? std::ceil(width / static_cast<double>(part.tile_width)) *
                                      std::ceil(height / static_cast<double>(part.tile_height))
                                : std::ceil(height / lines);
    check_compression(path_, chunks * 8, size_, 1);  // the chunk table itself is not compressed
    if (part.deep) return;                           // refused by the caller before any pixel is touched

    const double buffer =
        part.pixel_bytes *
        (tiled ? static_cast<double>(part.tile_width) * static_cast<double>(part.tile_height) : width * lines);
    if (buffer > harmless_bytes) check_compression(path_, buffer, size_, ratio);
  }

  std::string path_;
  std::int64_t size_;
  std::int64_t position_ = 0;
  std::ifstream file_;
};

}  // namespace

int exr_chunk_lines(int compression) {
  constexpr std::array lines{1, 1, 1, 16, 32, 16, 32, 32, 32, 256};  // none rle zips zip piz pxr24 b44 b44a dwaa dwab
  return compression >= 0 && compression < static_cast<int>(lines.size()) ? lines[static_cast<std::size_t>(compression)]
                                                                          : 0;
}

void scan_exr_header(const std::string& path) { Scanner(path).run(); }

}  // namespace mtf::io
