// SPDX-License-Identifier: Apache-2.0
#include "mtf/io/codecs/raster_scan.h"

#include <algorithm>
#include <array>
#include <fstream>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <string_view>

#include "mtf/error.h"
#include "mtf/io/file_checks.h"
#include "mtf/words.h"

namespace mtf::io {
namespace {

// What PNG and JPEG have in common: single values of Exif, which has the layout of a TIFF (CIPA DC-008), and densities.

/// The value of a tag in the first directory, a whole number of 16 or 32 bits; nothing when it is not there.
std::optional<std::uint32_t> tag_value(std::span<const unsigned char> tiff, std::uint16_t tag) {
  if (tiff.size() < 8) return std::nullopt;
  const bool little = tiff[0] == 'I';
  const auto number = [&](std::size_t at, std::size_t bytes) {
    std::uint32_t value = 0;
    for (std::size_t i = 0; i < bytes; ++i) value = value << 8U | tiff[at + (little ? bytes - 1 - i : i)];
    return value;
  };
  const std::size_t directory = number(4, 4);
  if (directory > tiff.size() - 2) return std::nullopt;
  constexpr std::size_t row = 12;
  const std::size_t rows = std::min<std::size_t>(number(directory, 2), (tiff.size() - directory - 2) / row);
  for (std::size_t i = 0; i < rows; ++i) {
    const std::size_t at = directory + 2 + i * row;
    constexpr std::uint32_t of_16_bits = 3;
    if (number(at, 2) == tag) return number(at + 8, number(at + 2, 2) == of_16_bits ? 2 : 4);
  }
  return std::nullopt;
}

/// Adds a note where the orientation of the Exif data is not that of the rows and columns as stored.
void note_orientation(std::span<const unsigned char> exif, std::vector<std::string>& notes) {
  constexpr std::uint16_t orientation = 0x0112;
  const std::uint32_t value = tag_value(exif, orientation).value_or(1);
  if (value > 1 && value <= 8)
    notes.push_back("its orientation (Exif " + std::to_string(value) +
                    ") is not applied: rows and columns are those stored");
}

/// Width of a pixel over its height, from pixels per length along x and y, which are rounded to whole numbers; 1 when
/// one of them is 0.
double aspect_of_densities(std::uint32_t x, std::uint32_t y) {
  const std::uint32_t difference = std::max(x, y) - std::min(x, y);
  return x == 0 || y == 0 || (difference == 1 && x > 100) ? 1.0 : static_cast<double>(y) / x;
}

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
  if (header.width == 0 || header.height == 0) damaged(path, "the image has no pixels");
  check_raster_size(path, "PNG", header.width, header.height);
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

using Segment = std::span<const unsigned char>;

// Markers of T.81, table B.1, and those that applications use.
constexpr int kSof0 = 0xc0, kSof2 = 0xc2, kSofLast = 0xcf, kDht = 0xc4, kJpg = 0xc8, kDac = 0xcc, kRst0 = 0xd0,
              kRst7 = 0xd7, kSoi = 0xd8, kEoi = 0xd9, kSos = 0xda, kDqt = 0xdb, kApp0 = 0xe0, kApp1 = 0xe1,
              kApp2 = 0xe2, kApp3 = 0xe3, kAdobe = 0xee, kAppLast = 0xef, kComment = 0xfe;

constexpr std::size_t kBlock = 64;  // coefficients
constexpr std::int64_t kMostBytes = std::int64_t{1} << 31;

/// What the segments say, as far as it is used.
struct JpegFacts {
  RasterHeader header;
  std::array<std::vector<std::uint16_t>, 4> tables;
  int components = 0;
  int luminance_table = 0;
  std::string sampling;  // "2x2": pixels of luminance to one of chroma
  bool rgb = false;      // component names R, G, B
  int adobe_transform = -1;
  std::vector<unsigned char> profile;
  std::map<int, std::string> flir;  // stretches of an FFF by their number
  int last_flir = 0;
  bool of_dji = false;
  std::string dji;                     // the segments in which its cameras have their counts
  std::map<int, std::size_t> unknown;  // bytes in segments of applications, by their number, that are not known here
};

[[noreturn]] void damaged_jpeg(const std::string& path, const std::string& why) {
  throw RuntimeError("cannot read " + path + ": damaged or incomplete JPEG file (" + why +
                     "); copy or export the file again");
}

[[noreturn]] void unsupported_jpeg(const std::string& path, const std::string& what) {
  throw RuntimeError("cannot read " + path + ": " + what + "; convert it to PNG or TIFF");
}

int two_bytes(Segment bytes, std::size_t at) { return bytes[at] << 8 | bytes[at + 1]; }

bool starts_with(Segment bytes, std::string_view word) {
  return bytes.size() >= word.size() && std::equal(word.begin(), word.end(), bytes.begin());
}

/// B.2.4.1: precision and place of a table in one byte, then 64 steps of one or two bytes.
void read_quantisation(const std::string& path, Segment data, JpegFacts& facts) {
  while (!data.empty()) {
    const std::size_t width = (data[0] >> 4U) == 0 ? 1 : 2, place = data[0] & 15U;
    if ((data[0] >> 4U) > 1 || place > 3 || data.size() < 1 + width * kBlock) damaged_jpeg(path, "quantisation table");
    std::vector<std::uint16_t>& table = facts.tables[place];
    table.clear();
    for (std::size_t i = 0; i < kBlock; ++i)
      table.push_back(static_cast<std::uint16_t>(width == 1 ? data[1 + i] : two_bytes(data, 1 + 2 * i)));
    if (std::find(table.begin(), table.end(), 0) != table.end()) damaged_jpeg(path, "a quantisation step of 0");
    data = data.subspan(1 + width * kBlock);
  }
}

/// B.2.2: precision, rows, columns, then name, sampling and table of each component; luminance is the first.
void read_frame(const std::string& path, int marker, Segment data, JpegFacts& facts) {
  if (facts.components > 0) damaged_jpeg(path, "more than one frame");
  if (marker > kSof2) unsupported_jpeg(path, "a lossless, hierarchical or arithmetic JPEG");
  if (data.size() < 6 || data.size() < 6 + 3 * std::size_t{data[5]})
    damaged_jpeg(path, "the frame header is too short");
  if (data[0] != 8) unsupported_jpeg(path, "a JPEG of " + std::to_string(data[0]) + " bits");
  facts.header.height = two_bytes(data, 1);
  facts.header.width = two_bytes(data, 3);
  if (facts.header.width == 0 || facts.header.height == 0) damaged_jpeg(path, "the image has no pixels");
  facts.components = data[5];
  if (facts.components != 1 && facts.components != 3)
    unsupported_jpeg(path, "a JPEG of " + std::to_string(data[5]) + " colours, such as CMYK");
  facts.luminance_table = data[8] & 3;
  if (facts.components == 3) {
    facts.rgb = data[6] == 'R' && data[9] == 'G' && data[12] == 'B';
    const int across = std::max(1, data[10] >> 4), down = std::max(1, data[10] & 15);
    facts.sampling = size_text((data[7] >> 4) / across, (data[7] & 15) / down);
  }
  facts.header.storage = marker == kSof2 ? "8-bit progressive" : "8-bit";
}

/// `at` is the first byte that follows a scan's header. Returns the place of the next marker that is neither a stuffed
/// byte nor a restart.
std::size_t end_of_scan(Segment file, std::size_t at) {
  for (; at + 1 < file.size(); ++at) {
    const int next = file[at + 1];
    if (file[at] == 0xff && next != 0 && next != 0xff && !(next >= kRst0 && next <= kRst7)) return at;
  }
  return file.size();
}

/// APP0 to APP15. What is not known may hold the raw counts of a thermal camera, beside which the image is a picture of
/// them in colours.
void read_application(int marker, Segment data, JpegFacts& facts) {
  using std::string_view_literals::operator""sv;
  std::vector<std::string>& notes = facts.header.notes;
  if (marker == kApp0 && starts_with(data, "JFIF\0"sv) && data.size() >= 12) {
    facts.header.pixel_aspect = aspect_of_densities(static_cast<std::uint32_t>(two_bytes(data, 8)),
                                                    static_cast<std::uint32_t>(two_bytes(data, 10)));
  } else if (marker == kApp1 && starts_with(data, "Exif\0\0"sv)) {
    note_orientation(data.subspan(6), notes);
    constexpr std::uint16_t make = 0x010f;
    const std::uint32_t letters = tag_value(data.subspan(6), make).value_or(0);
    facts.of_dji = letters == 0x00494a44U || letters == 0x444a4900U;  // "DJI" in either order of bytes
  } else if (marker == kApp3 && facts.of_dji) {
    facts.dji.append(data.begin(), data.end());
  } else if (marker == kApp1 && starts_with(data, "FLIR\0"sv)) {
    // "FLIR", 0, 1, the number of the segment and that of the last one; each holds a further stretch of the FFF.
    if (data.size() < 8) return;
    facts.flir[data[6]].assign(data.begin() + 8, data.end());
    facts.last_flir = data[7];
  } else if (marker == kApp2 && starts_with(data, "ICC_PROFILE") && data.size() > 14) {  // in order, as writers do
    facts.profile.insert(facts.profile.end(), data.begin() + 14, data.end());
  } else if (marker == kApp2 && starts_with(data, "MPF\0"sv)) {
    constexpr std::uint16_t number_of_images = 0xb001;
    if (const std::uint32_t images = tag_value(data.subspan(4), number_of_images).value_or(2); images > 1)
      notes.push_back("read as the first of " + std::to_string(images) + " images (MPF): the others are not read");
  } else if (marker == kAdobe && starts_with(data, "Adobe") && data.size() >= 12) {
    facts.adobe_transform = data[11];
  } else if (!starts_with(data, "JFXX") && !starts_with(data, "http://ns.adobe.com/") &&
             !starts_with(data, "Photoshop 3.0") && !starts_with(data, "Ducky")) {
    facts.unknown[marker - kApp0] += data.size();
  }
}

void read_segment(const std::string& path, int marker, Segment data, JpegFacts& facts) {
  if (marker == kDqt) {
    read_quantisation(path, data, facts);
  } else if (marker >= kSof0 && marker <= kSofLast && marker != kDht && marker != kJpg && marker != kDac) {
    read_frame(path, marker, data, facts);
  } else if (marker >= kApp0 && marker <= kAppLast) {
    read_application(marker, data, facts);
  }
}

/// `behind`: what comes after the end of the image; zeros only fill a block.
void note_unread(JpegFacts& facts, Segment behind) {
  std::vector<std::string>& notes = facts.header.notes;
  constexpr const char* maybe = " are not read: they may hold raw counts, or another image";
  for (const auto& [number, bytes] : facts.unknown)
    notes.push_back(std::to_string(bytes) + " bytes in its segments APP" + std::to_string(number) + maybe);
  if (std::any_of(behind.begin(), behind.end(), [](unsigned char byte) { return byte != 0; }))
    notes.push_back(std::to_string(behind.size()) + " bytes after the end of the image" + maybe);
}

/// All segments in order; `keep` receives the bytes that decoding needs.
JpegFacts read_segments(const std::string& path, Segment file, std::vector<unsigned char>* keep) {
  const auto copy = [&](std::size_t from, std::size_t to) {
    if (keep != nullptr)
      keep->insert(keep->end(), file.begin() + static_cast<std::ptrdiff_t>(from),
                   file.begin() + static_cast<std::ptrdiff_t>(to));
  };
  JpegFacts facts;
  if (file.size() < 4 || file[0] != 0xff || file[1] != kSoi) damaged_jpeg(path, "no start of image");
  copy(0, 2);
  for (std::size_t at = 2; at + 1 < file.size();) {
    if (file[at] != 0xff) damaged_jpeg(path, "no marker where one belongs");
    const int marker = file[at + 1];
    if (marker == 0xff) {  // fill
      ++at;
      continue;
    }
    if (marker == kEoi) {
      copy(at, at + 2);
      note_unread(facts, file.subspan(at + 2));
      return facts;
    }
    if (at + 4 > file.size()) break;
    const std::size_t end = at + 2 + static_cast<std::size_t>(two_bytes(file, at + 2));
    if (end < at + 4 || end > file.size()) break;
    read_segment(path, marker, file.subspan(at + 4, end - at - 4), facts);
    if (marker == kSos && facts.components == 0) damaged_jpeg(path, "pixels before the frame header");
    const std::size_t next = marker == kSos ? end_of_scan(file, end) : end;
    const bool application = (marker >= kApp0 && marker <= kAppLast) || marker == kComment;
    if (!application) copy(at, next);
    at = next;
  }
  damaged_jpeg(path, "it ends before the end of the image");
}

/// JPEG has no word for its curve: files are in sRGB by convention (JFIF, Exif), whatever the primaries of a profile.
StatedEncoding encoding_of(const JpegFacts& facts) {
  if (facts.profile.empty()) return {"srgb", "JPEG, sRGB by convention"};
  return {"srgb", "JPEG with the ICC profile \"" + printable(icc_name(facts.profile), 79) + "\""};
}

}  // namespace

RasterHeader scan_png(const std::string& path) {
  const std::int64_t file_bytes = input_file_size(path);
  std::ifstream file(path, std::ios::binary);
  if (!file) throw RuntimeError("cannot read " + path + ": it cannot be opened; check its permissions");
  return scan_png(path, file, file_bytes);
}

RasterHeader scan_png(const std::string& path, std::istream& file, std::int64_t file_bytes, Bytes* critical) {
  file.clear();
  file.seekg(0);
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

RasterHeader scan_jpeg(const std::string& path, std::vector<unsigned char>* critical) {
  const std::int64_t size = input_file_size(path);
  if (size > kMostBytes) unsupported_jpeg(path, "a JPEG of more than 2 GiB");
  std::vector<unsigned char> bytes(static_cast<std::size_t>(size));
  std::ifstream file(path, std::ios::binary);
  if (!file.read(reinterpret_cast<char*>(bytes.data()), size))
    throw RuntimeError("cannot read " + path + ": it cannot be opened; check its permissions");
  if (critical != nullptr) critical->clear();
  JpegFacts facts = read_segments(path, bytes, critical);
  if (facts.components == 0) damaged_jpeg(path, "no frame header");
  if (facts.components == 3 && (facts.rgb || facts.adobe_transform == 0))
    unsupported_jpeg(path, "a JPEG that stores red, green and blue and has no luminance plane");
  RasterHeader header = std::move(facts.header);
  if (const auto all = static_cast<std::size_t>(facts.last_flir) + 1; !facts.flir.empty() && facts.flir.size() != all)
    header.notes.push_back(std::to_string(facts.flir.size()) + (facts.flir.size() < all ? " of " : " in place of ") +
                           std::to_string(all) +
                           " segments with the raw counts of the camera are in it: they are not read");
  else
    for (const auto& [number, stretch] : facts.flir) header.flir += stretch;
  header.dji = std::move(facts.dji);
  header.dct_steps = facts.tables[static_cast<std::size_t>(facts.luminance_table)];
  if (header.dct_steps.empty()) damaged_jpeg(path, "no quantisation table of the luminance plane");
  if (header.width * header.height > max_plane_pixels / 2) unsupported_jpeg(path, "a JPEG of more than 2^30 pixels");
  check_compression(path, static_cast<double>(header.width * header.height), size, 2000.0);
  header.type = "uint8";
  if (facts.components == 3) header.storage += ", luminance of a colour image, chroma " + facts.sampling;
  header.encoding = encoding_of(facts);
  return header;
}

}  // namespace mtf::io
