// SPDX-License-Identifier: Apache-2.0
#include "mtf/io/codecs/jpeg_scan.h"

#include <algorithm>
#include <array>
#include <fstream>
#include <map>
#include <span>
#include <string_view>

#include "mtf/error.h"
#include "mtf/io/codecs/exif.h"
#include "mtf/io/file_checks.h"
#include "mtf/words.h"

namespace mtf::io {
namespace {

using Segment = std::span<const unsigned char>;

// Markers of T.81, table B.1, and those that applications use.
constexpr int kSof0 = 0xc0, kSof2 = 0xc2, kSofLast = 0xcf, kDht = 0xc4, kJpg = 0xc8, kDac = 0xcc, kRst0 = 0xd0,
              kRst7 = 0xd7, kSoi = 0xd8, kEoi = 0xd9, kSos = 0xda, kDqt = 0xdb, kApp0 = 0xe0, kApp1 = 0xe1,
              kApp2 = 0xe2, kAdobe = 0xee, kAppLast = 0xef, kComment = 0xfe;

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
    facts.sampling = std::to_string((data[7] >> 4) / across) + "x" + std::to_string((data[7] & 15) / down);
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
  } else if (marker == kApp1 && starts_with(data, "FLIR\0"sv)) {
    constexpr std::string_view flir =
        "it holds the raw counts of a FLIR camera, which are not read: what is read is a picture of them; take them "
        "out, as `exiftool -b -RawThermalImage` does";
    if (std::find(notes.begin(), notes.end(), flir) == notes.end()) notes.emplace_back(flir);
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
