// SPDX-License-Identifier: Apache-2.0
#include "mtf/io/exr/exr_open.h"

#include <OpenEXR/ImfBoxAttribute.h>
#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfChromaticitiesAttribute.h>
#include <OpenEXR/ImfCompression.h>
#include <OpenEXR/ImfDoubleAttribute.h>
#include <OpenEXR/ImfFloatAttribute.h>
#include <OpenEXR/ImfFloatVectorAttribute.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfIntAttribute.h>
#include <OpenEXR/ImfPartType.h>
#include <OpenEXR/ImfRationalAttribute.h>
#include <OpenEXR/ImfStandardAttributes.h>
#include <OpenEXR/ImfStringAttribute.h>
#include <OpenEXR/ImfStringVectorAttribute.h>
#include <OpenEXR/ImfTileDescription.h>
#include <OpenEXR/ImfVecAttribute.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <fstream>
#include <initializer_list>
#include <limits>

#include "mtf/io/channel_choice.h"
#include "mtf/io/csv/csv_cells.h"
#include "mtf/work/stop.h"

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

// Lines of one chunk of a scan-line part with this compression code, 0 for an unknown one.
int exr_chunk_lines(int compression) {
  constexpr std::array lines{1, 1, 1, 16, 32, 16, 32, 32, 32, 256};  // none rle zips zip piz pxr24 b44 b44a dwaa dwab
  return compression >= 0 && compression < static_cast<int>(lines.size()) ? lines[static_cast<std::size_t>(compression)]
                                                                          : 0;
}

// The attributes of every part (format: OpenEXR file layout, version 2), against what the file can hold.
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

template <class T>
std::string numbers(std::initializer_list<T> values) {
  return joined(values, number_text<T>, " ");
}

// "" for types that have no useful text.
std::string attribute_text(const Imf::Attribute& attribute) {
  const auto* a = &attribute;
  if (const auto* s = dynamic_cast<const Imf::StringAttribute*>(a)) return s->value();
  if (const auto* i = dynamic_cast<const Imf::IntAttribute*>(a)) return number_text(i->value());
  if (const auto* f = dynamic_cast<const Imf::FloatAttribute*>(a)) return number_text(f->value());
  if (const auto* d = dynamic_cast<const Imf::DoubleAttribute*>(a)) return number_text(d->value());
  if (const auto* v = dynamic_cast<const Imf::V2dAttribute*>(a)) return numbers({v->value().x, v->value().y});
  if (const auto* v = dynamic_cast<const Imf::V2fAttribute*>(a)) return numbers({v->value().x, v->value().y});
  if (const auto* v = dynamic_cast<const Imf::V2iAttribute*>(a)) return numbers({v->value().x, v->value().y});
  if (const auto* v = dynamic_cast<const Imf::V3fAttribute*>(a))
    return numbers({v->value().x, v->value().y, v->value().z});
  if (const auto* v = dynamic_cast<const Imf::V3dAttribute*>(a))
    return numbers({v->value().x, v->value().y, v->value().z});
  if (const auto* b = dynamic_cast<const Imf::Box2iAttribute*>(a))
    return numbers({b->value().min.x, b->value().min.y, b->value().max.x, b->value().max.y});
  if (const auto* r = dynamic_cast<const Imf::RationalAttribute*>(a))
    return number_text(static_cast<double>(r->value()));
  if (const auto* c = dynamic_cast<const Imf::ChromaticitiesAttribute*>(a)) {
    const Imf::Chromaticities& p = c->value();
    return numbers({p.red.x, p.red.y, p.green.x, p.green.y, p.blue.x, p.blue.y, p.white.x, p.white.y});
  }
  if (const auto* list = dynamic_cast<const Imf::FloatVectorAttribute*>(a))
    return joined(list->value(), number_text<float>, " ");
  if (const auto* list = dynamic_cast<const Imf::StringVectorAttribute*>(a)) return joined(list->value(), "\n");
  return "";
}

std::string type_name(Imf::PixelType type) { return type == Imf::UINT ? "uint" : type == Imf::HALF ? "half" : "float"; }

std::string compression_name(Imf::Compression compression) {
  constexpr std::array names{"uncompressed", "rle", "zips", "zip", "piz", "pxr24", "b44", "b44a", "dwaa", "dwab"};
  return names.at(static_cast<std::size_t>(compression));
}

// Stored in tiles: by type, or by the tile description of old single-part files.
bool is_tiled(const Imf::Header& header) {
  if (header.hasType()) return header.type() == Imf::TILEDIMAGE || header.type() == Imf::DEEPTILE;
  return header.hasTileDescription();
}

std::string part_storage(const Imf::Header& header) {
  std::string text = header.hasType() && header.type().starts_with("deep") ? "deep " : "";
  text += (is_tiled(header) ? "tiled " : "scanline ") + compression_name(header.compression());
  if (!header.hasTileDescription()) return text;
  const Imf::TileDescription tiles = header.tileDescription();
  if (tiles.mode == Imf::ONE_LEVEL) return text;
  const auto& window = header.dataWindow();
  const auto levels = [&](std::int64_t size) {
    int count = 1;
    for (; size > 1; size = tiles.roundingMode == Imf::ROUND_DOWN ? size / 2 : (size + 1) / 2) ++count;
    return count;
  };
  const int x = levels(std::int64_t{window.max.x} - window.min.x + 1);
  const int y = levels(std::int64_t{window.max.y} - window.min.y + 1);
  if (tiles.mode == Imf::MIPMAP_LEVELS) return text + ", " + std::to_string(std::max(x, y)) + " mip-map levels";
  return text + ", " + std::to_string(x) + " x " + std::to_string(y) + " rip-map levels";
}

std::array<int, 4> corners_of(const Imath::Box2i& box) { return {box.min.x, box.min.y, box.max.x, box.max.y}; }

void add_part(FileInfo& info, const Imf::Header& header, int part) {
  const bool deep = header.hasType() && header.type().starts_with("deep");
  for (auto c = header.channels().begin(); c != header.channels().end(); ++c) {
    ChannelInfo channel;
    channel.name = c.name();
    channel.type = std::string(deep ? "deep " : "") + type_name(c.channel().type);
    channel.layer = layer_of(channel.name);
    channel.part = part;
    channel.part_name = header.hasName() ? header.name() : "";
    channel.x_sampling = c.channel().xSampling;
    channel.y_sampling = c.channel().ySampling;
    info.channels.push_back(channel);
  }
}

/// Those that have a text and are not there yet.
void add_attributes(FileInfo& info, const Imf::Header& header) {
  for (auto a = header.begin(); a != header.end(); ++a) {
    const std::string name = a.name();
    if (name == "dataWindow" || name == "displayWindow" || name == "chunkCount") continue;
    const std::string text = attribute_text(a.attribute());
    if (!text.empty()) info.attributes.emplace(name, text);
  }
}

/// Whether decoding gives other values than those that were written. B44 leaves `float` alone, PXR24 `half`.
bool loses(const Imf::Header& header) {
  const Imf::Compression compression = header.compression();
  const auto has = [&](Imf::PixelType type) {
    for (auto c = header.channels().begin(); c != header.channels().end(); ++c)
      if (c.channel().type == type) return true;
    return false;
  };
  if (compression == Imf::PXR24_COMPRESSION) return has(Imf::FLOAT);
  if (compression == Imf::B44_COMPRESSION || compression == Imf::B44A_COMPRESSION) return has(Imf::HALF);
  return compression == Imf::DWAA_COMPRESSION || compression == Imf::DWAB_COMPRESSION;
}

/// Attributes of the part that change what its values mean.
void add_notes(FileInfo& info, const Imf::Header& header) {
  const auto stated = [&](const char* name) { return header.find(name) == header.end() ? "" : info.attributes[name]; };
  if (loses(header))
    info.notes.push_back("compressed with a loss that it does not state (" + compression_name(header.compression()) +
                         "): fine structure and noise may be gone");
  if (Imf::hasMultiView(header) && Imf::multiView(header).size() > 1)
    info.notes.push_back("it has the views " + joined(Imf::multiView(header), ",") +
                         " (multiView): channels without a layer are those of the first");
  if (Imf::hasEnvmap(header)) info.notes.push_back("an image of all directions (envmap), which no lens takes");
  if (const std::string white = stated("whiteLuminance"); !white.empty())
    info.notes.push_back("white is " + white + " cd/m2 by its attribute whiteLuminance, which is not used");
  for (const char* name : {"colorInteropID", "oiio:ColorSpace"}) {
    const std::string space = lower_case(stated(name));
    if (!space.empty() && space.find("lin") == std::string::npos && !space.starts_with("aces") && space != "data" &&
        space != "raw")
      info.notes.push_back("its " + std::string(name) + " is " + info.attributes[name] +
                           "; its values are taken as linear, as OpenEXR defines them");
  }
}

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

void scan_exr_header(const std::string& path) { Scanner(path).run(); }

FileInfo describe_exr(const Imf::MultiPartInputFile& file, int part) {
  FileInfo info;
  info.format = Format::exr;
  const Imf::Header& own = file.header(part);
  info.data_window = corners_of(own.dataWindow());
  info.display_window = corners_of(own.displayWindow());
  info.pixel_aspect = static_cast<double>(own.pixelAspectRatio());
  add_attributes(info, own);
  add_notes(info, own);
  info.width = std::int64_t{info.display_window[2]} - info.display_window[0] + 1;
  info.height = std::int64_t{info.display_window[3]} - info.display_window[1] + 1;
  if (file.parts() > 1) info.storage = std::to_string(file.parts()) + " parts: ";
  constexpr int shown = 8;
  for (int i = 0; i < file.parts(); ++i) {
    if (i < shown) info.storage += std::string(i > 0 ? ", " : "") + part_storage(file.header(i));
    if (i == shown) info.storage += ", ...";
    add_part(info, file.header(i), i);
    add_attributes(info, file.header(i));
  }
  return info;
}

Imf::FrameBuffer frame_buffer(const std::vector<std::string>& channels, const std::vector<float*>& planes,
                              std::int64_t x0, std::int64_t y0, std::int64_t stride, bool whole_numbers) {
  Imf::FrameBuffer buffer;
  for (std::size_t i = 0; i < channels.size(); ++i) {
    // The library adds coordinates to a base outside the plane; through integers this is well defined.
    const auto origin = static_cast<std::uintptr_t>((y0 * stride + x0) * std::int64_t{sizeof(float)});
    auto* base = reinterpret_cast<char*>(reinterpret_cast<std::uintptr_t>(planes[i]) - origin);
    buffer.insert(channels[i], Imf::Slice(whole_numbers ? Imf::UINT : Imf::FLOAT, base, sizeof(float),
                                          static_cast<std::size_t>(stride) * sizeof(float)));
  }
  return buffer;
}

PixelSource::PixelSource(Imf::MultiPartInputFile& file, int part) {
  const Imf::Header& header = file.header(part);
  if (is_tiled(header)) {
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
    whole_numbers = whole_numbers && image.info.channels[i].type == "uint";
  }
  image.names = choice.names;
  check_plane_pixels(path, data.width(), data.height());
  check_plane_pixels(path, display.width(), display.height());
  check_display_window(path, data, display);
  image.missing_pixels = display.width() * display.height() - overlap(data, display);
}

}  // namespace mtf::io
