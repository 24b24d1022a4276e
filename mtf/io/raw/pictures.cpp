// SPDX-License-Identifier: Apache-2.0

// PGM and PPM (Netpbm): P2 and P5 grey, P3 and P6 red, green and blue, in digits or as bytes, of which numbers above
// 255 have two, the greater first. Header: width, height and the largest possible value, after any comments `# ...`.
// BMP: a header of at least 40 bytes (BITMAPINFOHEADER and those after it), rows of whole 4 bytes from the lowest up,
// or downwards where the height is negative; 8 bits grey, 24 and 32 bits blue, green, red. Values are counts as they
// are stored. Neither format says how they follow from light, but for BMP of sRGB.

#include <algorithm>
#include <array>
#include <charconv>
#include <cstdlib>
#include <cstring>
#include <fstream>

#include "mtf/error.h"
#include "mtf/io/csv/curve_csv.h"
#include "mtf/io/file_checks.h"
#include "mtf/io/raw/raw_image.h"
#include "mtf/words.h"

namespace mtf::io {
namespace {

constexpr std::size_t kLongestStart = 65536;
constexpr std::size_t kMostDigits = std::size_t{1} << 32;  // bytes of a file of them

[[noreturn]] void unreadable(const std::string& path, const std::string& why) {
  throw RuntimeError("cannot read " + path + ": " + why);
}

std::string start_of(const std::string& path) {
  std::string start(kLongestStart, '\0');
  std::ifstream file(path, std::ios::binary);
  file.read(start.data(), static_cast<std::streamsize>(start.size()));
  start.resize(static_cast<std::size_t>(file.gcount()));
  return start;
}

bool is_blank(char c) { return c == ' ' || (c >= '\t' && c <= '\r'); }

/// The next number, after blanks and comments; `at` is the place behind it. -1 where there is none.
std::int64_t next_number(std::string_view text, std::size_t& at) {
  while (at < text.size() && (is_blank(text[at]) || text[at] == '#'))
    at = text[at] == '#' ? std::min(text.find('\n', at), text.size()) : at + 1;
  std::int64_t value = -1;
  const auto [end, status] = std::from_chars(text.data() + at, text.data() + text.size(), value);
  at = static_cast<std::size_t>(end - text.data());
  return status == std::errc{} ? value : -1;
}

/// The samples of P2 and P3, as numbers of 16 bits.
std::vector<char> samples_in_digits(const std::string& path, std::size_t at, std::int64_t count, std::int64_t largest) {
  const std::string text = read_file(path, kMostDigits);
  std::vector<char> bytes;
  bytes.reserve(2 * static_cast<std::size_t>(count));
  for (std::int64_t i = 0; i < count; ++i) {
    const std::int64_t value = next_number(text, at);
    if (value < 0 || value > largest)
      unreadable(path,
                 "sample " + std::to_string(i + 1) + " of " + std::to_string(count) +
                     (value < 0 ? " is missing or no number" : " is above the largest value that the header states") +
                     "; export the file again");
    bytes.push_back(static_cast<char>(value & 255));
    bytes.push_back(static_cast<char>(value >> 8));
  }
  return bytes;
}

template <class Number>
Number little_endian(std::string_view bytes, std::size_t at) {
  Number value{};
  std::memcpy(&value, bytes.data() + at, sizeof value);
  return value;
}

std::vector<RawImage> only_image(RawImage&& image) {
  std::vector<RawImage> images;
  images.push_back(std::move(image));
  return images;
}

}  // namespace

std::vector<RawImage> open_pnm(const std::string& path, Part) {
  const std::int64_t size = input_file_size(path);
  const std::string start = start_of(path);
  const char kind = start[1];
  RawImage image;
  image.info.format = Format::pnm;
  image.file = path;
  std::size_t at = 2;
  image.info.width = next_number(start, at);
  image.info.height = next_number(start, at);
  const std::int64_t largest = next_number(start, at);
  if (largest < 1 || largest > 65535)
    unreadable(path, "damaged PGM or PPM file: width, height and the largest value, from 1 to 65535, belong behind P" +
                         std::string(1, kind) + "; export the file again");
  const bool digits = kind < '4', wide = digits || largest > 255;
  image.type = NumberType{'u', digits ? 1 : (wide ? 2 : 1), true};
  const std::int64_t planes = kind == '3' || kind == '6' ? 3 : 1;
  image.begin = static_cast<std::int64_t>(at) + 1;  // one blank
  // A sample in digits has one and a blank, but for the last.
  const std::int64_t more = check_samples(path, image, digits ? image.begin - 1 : image.begin, planes);
  image.planes.resize(static_cast<std::size_t>(planes));
  image.info.storage = (largest > 255 ? "16-bit" : "8-bit") + std::string(digits ? ", in digits" : "");
  if (digits) {
    image.type = NumberType{'u', 2, false};
    image.held = samples_in_digits(path, at, image.info.width * image.info.height * planes, largest);
    image.begin = 0;
  } else if (more > 0) {
    image.info.notes.push_back(plural(more, "byte") + " of " + std::to_string(size) +
                               " follow the image and are not read: they may hold further images");
  }
  interleave_pixels(image);
  name_channels(image, planes == 3 ? std::vector<std::string>{"R", "G", "B"} : std::vector<std::string>{"Y"});
  if (largest <= 255)
    for (ChannelInfo& channel : image.info.channels) channel.type = "uint8";
  image.info.largest = static_cast<double>(largest);
  return only_image(std::move(image));
}

std::vector<RawImage> open_bmp(const std::string& path, Part) {
  const std::string start = start_of(path);
  constexpr std::size_t kFileHeader = 14, kInfoHeader = 40, kColourSpace = 70;
  if (start.size() < kFileHeader + kInfoHeader) unreadable(path, "the BMP file ends in its header; copy it again");
  const auto header = little_endian<std::uint32_t>(start, 14);
  const auto bits = little_endian<std::uint16_t>(start, 28);
  const auto compression = little_endian<std::uint32_t>(start, 30);
  const auto width = little_endian<std::int32_t>(start, 18), height = little_endian<std::int32_t>(start, 22);
  const auto colours = little_endian<std::uint32_t>(start, 46);
  const bool grey = bits == 8;
  constexpr std::uint32_t bit_fields = 3;
  const bool usual_fields = bits == 32 && compression == bit_fields && start.size() >= 66 &&
                            little_endian<std::uint32_t>(start, 54) == 0xff0000U &&
                            little_endian<std::uint32_t>(start, 58) == 0xff00U &&
                            little_endian<std::uint32_t>(start, 62) == 0xffU;
  if (header < kInfoHeader || (!grey && bits != 24 && bits != 32) || (compression != 0 && !usual_fields))
    unreadable(path, "a BMP of " + std::to_string(bits) + " bits a pixel, compression " + std::to_string(compression) +
                         " and a header of " + std::to_string(header) +
                         " bytes; read are plain ones of 8, 24 and 32 bits: convert it to PNG");
  for (std::size_t i = 0; grey && i < (colours == 0 ? 256 : std::min(colours, 256U)); ++i) {
    const std::size_t at = kFileHeader + header + 4 * i;
    if (at + 3 > start.size()) unreadable(path, "the BMP file ends in its palette; copy it again");
    for (std::size_t c = 0; c < 3; ++c)
      if (static_cast<unsigned char>(start[at + c]) != i)
        unreadable(path, "its values are numbers of a palette that is no scale of grey; convert it to PNG");
  }
  RawImage image;
  image.info.format = Format::bmp;
  image.file = path;
  image.info.width = width;
  image.info.height = std::abs(std::int64_t{height});
  image.info.storage = std::to_string(bits) + "-bit";
  const std::int64_t samples = bits / 8, padding = (4 - samples * image.info.width % 4) % 4;
  image.begin = little_endian<std::uint32_t>(start, 10);
  const std::size_t headers =
      kFileHeader + header + (grey ? 4 * std::size_t{colours == 0 ? 256 : std::min(colours, 256U)} : 0);
  if (image.begin < static_cast<std::int64_t>(headers))
    unreadable(path, "its numbers begin at byte " + std::to_string(image.begin) + ", within its headers of " +
                         std::to_string(headers) + " bytes; export the file again");
  check_samples(path, image, image.begin, samples, padding);
  image.planes.resize(static_cast<std::size_t>(samples));
  interleave_pixels(image, padding);
  if (height > 0) {
    image.begin += (image.info.height - 1) * image.row_step;
    image.row_step = -image.row_step;
  }
  if (!grey) {  // B,G,R, and a fourth that is nothing
    image.planes.resize(3);
    image.begin += 2;
    image.plane_step = -1;
  }
  name_channels(image, grey ? std::vector<std::string>{"Y"} : std::vector<std::string>{"R", "G", "B"});
  constexpr std::uint32_t srgb = 0x73524742, windows = 0x57696e20;  // "sRGB", "Win "
  if (header >= 108 && start.size() >= kColourSpace + 4)
    if (const auto space = little_endian<std::uint32_t>(start, kColourSpace); space == srgb || space == windows)
      image.info.encoding = {"srgb", "BMP header"};
  const std::int64_t x = little_endian<std::int32_t>(start, 38), y = little_endian<std::int32_t>(start, 42);
  if (x > 0 && y > 0 && std::abs(x - y) > 1) image.info.pixel_aspect = static_cast<double>(y) / static_cast<double>(x);
  return only_image(std::move(image));
}

}  // namespace mtf::io
