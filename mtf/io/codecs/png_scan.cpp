// SPDX-License-Identifier: Apache-2.0
#include "mtf/io/codecs/png_scan.h"

#include <algorithm>
#include <array>
#include <fstream>
#include <map>
#include <set>

#include "mtf/error.h"
#include "mtf/io/codecs/exif.h"
#include "mtf/io/file_checks.h"
#include "mtf/words.h"

namespace mtf::io {
namespace {

using Bytes = std::vector<unsigned char>;

constexpr std::size_t text_limit = 1 << 20;

constexpr std::array<std::uint32_t, 256> crc_table() {
  std::array<std::uint32_t, 256> table{};
  for (std::uint32_t n = 0; n < table.size(); ++n) {
    std::uint32_t c = n;
    for (int k = 0; k < 8; ++k) c = (c & 1U) != 0 ? 0xedb88320U ^ (c >> 1U) : c >> 1U;
    table[n] = c;
  }
  return table;
}

std::uint32_t crc(const unsigned char* bytes, std::size_t size) {
  static constexpr auto table = crc_table();
  std::uint32_t c = 0xffffffffU;
  for (std::size_t i = 0; i < size; ++i) c = table[(c ^ bytes[i]) & 0xffU] ^ (c >> 8U);
  return ~c;
}

std::uint32_t big_endian(const unsigned char* bytes) {
  return std::uint32_t{bytes[0]} << 24U | std::uint32_t{bytes[1]} << 16U | std::uint32_t{bytes[2]} << 8U | bytes[3];
}

[[noreturn]] void damaged(const std::string& path, const std::string& why) {
  throw RuntimeError("cannot read " + path + ": damaged or incomplete PNG file (" + why +
                     "); copy or export the file again");
}

void read_ihdr(const std::string& path, const unsigned char* data, std::size_t size, RasterHeader& header) {
  if (size != 13) damaged(path, "the header chunk has a wrong length");
  header.width = big_endian(data);
  header.height = big_endian(data + 4);
  const int bits = data[8], colour = data[9];
  constexpr std::int64_t max_side = 1 << 20;
  if (header.width == 0 || header.height == 0) damaged(path, "the image has no pixels");
  if (header.width > max_side || header.height > max_side || header.width * header.height > max_plane_pixels / 2)
    throw RuntimeError(path + ": a PNG of " + std::to_string(header.width) + " x " + std::to_string(header.height) +
                       " pixels needs " +
                       shown_bytes(static_cast<double>(header.width) * static_cast<double>(header.height) * 4) +
                       " a plane; the limit is 2^30 pixels and 2^20 a side: crop it, or store the image as OpenEXR");
  const bool grey = colour == 0 || colour == 4, indexed = colour == 3;
  const bool known = (grey || indexed || colour == 2 || colour == 6) &&
                     (bits == 8 || (bits == 16 && !indexed) ||
                      (bits < 8 && (bits == 1 || bits == 2 || bits == 4) && (colour == 0 || indexed)));
  if (!known) damaged(path, "unknown pixel layout");
  header.colours = grey ? 1 : 3;
  header.alpha = colour == 4 || colour == 6;
  header.type = bits == 16 ? "uint16" : "uint8";
  header.storage = std::to_string(bits) + "-bit" + (indexed ? " palette" : "") + (data[12] != 0 ? " interlaced" : "");
}

void read_text(const std::string& type, const unsigned char* data, std::size_t size, RasterHeader& header) {
  const std::string all(reinterpret_cast<const char*>(data), std::min(size, text_limit));
  const auto key_end = all.find('\0');
  if (key_end == std::string::npos || key_end == 0) return;
  std::size_t text = key_end + 1;
  if (type == "iTXt") {  // compression flag and method, language, translated key, text
    if (text >= all.size() || all[text] != 0) return;
    for (int skipped = 0; skipped < 2; ++skipped) {
      text = all.find('\0', skipped == 0 ? text + 2 : text);
      if (text == std::string::npos) return;
      ++text;
    }
  }
  header.attributes[all.substr(0, key_end)] = all.substr(text);
}

/// What is wrong with a chunk that says how values follow from light (PNG specification, 11.3.2); "" for a good one,
/// and for chunks that say other things.
std::string fault_of(const std::string& type, const unsigned char* data, std::size_t size) {
  const auto length = [&](std::size_t wanted) {
    return size == wanted ? "" : std::to_string(size) + " bytes in place of " + std::to_string(wanted);
  };
  if (type == "gAMA") return length(4);
  if (type == "sRGB") {
    if (size == 1 && data[0] > 3) return "rendering intent " + std::to_string(data[0]) + ", which is 0 to 3";
    return length(1);
  }
  if (type == "cICP") {
    if (size == 4 && data[3] > 1) return "range flag " + std::to_string(data[3]) + ", which is 0 or 1";
    return length(4);
  }
  if (type == "iCCP") {
    const auto name = static_cast<std::size_t>(std::find(data, data + size, 0) - data);
    if (name == 0 || name > 79 || name + 2 > size) return "no profile name of 1 to 79 characters";
    if (data[name + 1] != 0) return "compression method " + std::to_string(data[name + 1]) + ", which is 0";
  }
  return "";
}

/// The chunks that state how values follow from light. One that breaks the specification is not used, with a note.
class ColourChunks {
 public:
  void add(const std::string& type, const unsigned char* data, std::size_t size, bool after_pixels) {
    if (type != "sRGB" && type != "gAMA" && type != "cICP" && type != "iCCP") return;
    std::string fault = fault_of(type, data, size);
    if (fault.empty() && after_pixels) fault = "after the pixels";
    if (!seen_.insert(type).second) {  // it is unknown which of them counts
      fault = "more than one";
      forget(type);
    }
    if (!fault.empty()) {
      malformed_[type] = fault;
      return;
    }
    if (type == "sRGB") colour_.srgb = true;
    if (type == "gAMA") colour_.gamma_e5 = big_endian(data);
    if (type == "cICP") colour_.transfer = data[1];
    if (type == "iCCP") {
      const auto length = static_cast<std::size_t>(std::find(data, data + size, 0) - data);
      colour_.profile = printable({reinterpret_cast<const char*>(data), length}, 79);
    }
  }

  StatedEncoding stated() const {
    StatedEncoding stated = stated_by_png(colour_);
    for (const auto& [type, fault] : malformed_)
      stated.source += (stated.source.empty() ? "" : " beside ") + type + " chunk (malformed: " + fault + "; not used)";
    return stated;
  }

 private:
  void forget(const std::string& type) {
    if (type == "sRGB") colour_.srgb = false;
    if (type == "gAMA") colour_.gamma_e5.reset();
    if (type == "cICP") colour_.transfer.reset();
    if (type == "iCCP") colour_.profile.reset();
  }

  PngColour colour_;
  std::set<std::string> seen_;
  std::map<std::string, std::string> malformed_;
};

/// Chunks that say which pixels are no data, how they are shaped, and what else the file holds. What is not here says
/// nothing that would change a value: background, histogram, offset on a page, primaries, time.
void read_other(const std::string& type, const unsigned char* data, std::size_t size, RasterHeader& header) {
  if (type == "tRNS") {
    const bool grey = header.colours == 1 && size == 2;
    if (grey) {
      const int value = data[0] << 8 | data[1];
      header.no_data = {static_cast<float>(value), std::to_string(value) + " (tRNS)"};
    }
    header.alpha = header.alpha || !grey;
  }
  if (type == "pHYs" && size == 9) header.pixel_aspect = aspect_of_densities(big_endian(data), big_endian(data + 4));
  if (type == "sBIT" && size > 0)
    header.notes.push_back(std::to_string(data[0]) +
                           " bits of each value are significant (sBIT): its steps may be of more than one count");
  if (type == "acTL" && size == 8 && big_endian(data) > 1)
    header.notes.push_back("read as its still image: " + std::to_string(big_endian(data)) +
                           " images of an animation (acTL) are not read");
  if (type == "sCAL") header.notes.push_back("the size that it states of what a pixel shows (sCAL) is not used");
  if (type == "eXIf") note_orientation({data, size}, header.notes);
}

}  // namespace

RasterHeader scan_png(const std::string& path, Bytes* critical) {
  const std::int64_t file_bytes = input_file_size(path);
  std::ifstream file(path, std::ios::binary);
  if (!file) throw RuntimeError("cannot read " + path + ": it cannot be opened; check its permissions");
  Bytes chunk(8);
  const auto read = [&](std::size_t size) {
    chunk.resize(size);
    file.read(reinterpret_cast<char*>(chunk.data()), static_cast<std::streamsize>(size));
    return static_cast<bool>(file);
  };
  if (!read(8)) damaged(path, "it ends in the header");
  if (critical != nullptr) *critical = chunk;

  RasterHeader header;
  ColourChunks colour;
  bool first = true, any_data = false;
  for (std::int64_t left = file_bytes - 8;;) {
    if (left < 12 || !read(8)) damaged(path, "it ends before the end mark");
    const std::int64_t size = big_endian(chunk.data());
    const std::string type(chunk.begin() + 4, chunk.end());
    if (size > left - 12) damaged(path, "chunk " + printable(type) + " is longer than the file");
    std::array<unsigned char, 4> length{};
    std::copy_n(chunk.begin(), 4, length.begin());
    file.seekg(-4, std::ios::cur);  // the CRC covers type and data
    if (!read(static_cast<std::size_t>(size) + 8)) damaged(path, "chunk " + printable(type) + " cannot be read");
    left -= size + 12;
    const unsigned char* data = chunk.data() + 4;
    const auto data_size = static_cast<std::size_t>(size);
    if (crc(chunk.data(), data_size + 4) != big_endian(data + data_size))
      damaged(path, "chunk " + printable(type) + " has a wrong checksum");
    if (first != (type == "IHDR")) damaged(path, "the header chunk is missing or repeated");
    if (first) read_ihdr(path, data, data_size, header);
    first = false;
    any_data = any_data || type == "IDAT";
    read_other(type, data, data_size, header);
    if (type == "tEXt" || type == "iTXt") read_text(type, data, data_size, header);
    colour.add(type, data, data_size, any_data);
    const bool needed = type == "IHDR" || type == "PLTE" || type == "tRNS" || type == "IDAT" || type == "IEND";
    if (!needed && type[0] >= 'A' && type[0] <= 'Z') damaged(path, "unknown critical chunk " + printable(type));
    if (critical != nullptr && needed) {
      critical->insert(critical->end(), length.begin(), length.end());
      critical->insert(critical->end(), chunk.begin(), chunk.end());
    }
    if (type == "IEND") break;
  }
  if (!any_data) damaged(path, "it holds no pixels");
  header.encoding = colour.stated();
  if (header.alpha) header.notes.push_back("its alpha channel is not applied");
  if (header.storage.find("palette") != std::string::npos)
    header.notes.push_back("its values are colours of a palette, not measured ones");
  const double pixel_bytes = (header.colours + (header.alpha ? 1 : 0)) * (header.type == "uint16" ? 2.0 : 0.125);
  check_compression(path, static_cast<double>(header.width) * static_cast<double>(header.height) * pixel_bytes,
                    file_bytes, 2048);
  return header;
}

}  // namespace mtf::io
