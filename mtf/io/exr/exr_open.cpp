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
#include <initializer_list>

#include "mtf/io/channel_choice.h"
#include "mtf/io/csv/csv_cells.h"
#include "mtf/work/stop.h"

namespace mtf::io {
namespace {

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
  }
  image.names = choice.names;
  check_plane_pixels(path, data.width(), data.height());
  check_plane_pixels(path, display.width(), display.height());
  check_display_window(path, data, display);
  image.missing_pixels = display.width() * display.height() - overlap(data, display);
}

}  // namespace mtf::io
