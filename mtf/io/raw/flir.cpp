// SPDX-License-Identifier: Apache-2.0

// Images of FLIR's thermal cameras: counts of 16 bits with what the camera knew (facts as in the tables of tags of
// ExifTool and FLIR's fff.h). An FFF is a header of 64 bytes, "FFF" or "AFF", with the place and number of its records
// of 32 bytes: type, place and size. A sequence (SEQ) is one FFF after another, each a part here; a JPEG holds an FFF
// in its segments APP1.
//   record 1     counts: width and height, from byte 32 on whole numbers of either order or a PNG or, in CSQ, JPEG-LS
//   record 32    the camera: constants of its counts (radiometry/light/raw_counts.h), surface and air that it was told
// Each has 2 as its first number, by which its order of bytes is known. FLIR writes the samples of the PNG the least
// byte first, against the standard; the order is that in which neighbours differ less.
// DJI's cameras have their counts bare in the segments APP3 of a JPEG, 16 bits, the least byte first, as many as the
// picture has pixels or as one of half its size; what they are worth is not published.
// Attributes named camera_counts.R1 ... scene.emissivity, scene.surroundings have the names of the sensor file's keys.

#include <algorithm>
#include <array>
#include <bit>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <optional>
#include <span>
#include <sstream>

#include "mtf/error.h"
#include "mtf/io/codecs/codecs.h"
#include "mtf/io/codecs/raster_scan.h"
#include "mtf/io/csv/csv_cells.h"
#include "mtf/io/file_checks.h"
#include "mtf/io/raw/raw_image.h"
#include "mtf/words.h"

namespace mtf::io {
namespace {

using std::string_view_literals::operator""sv;

constexpr std::int64_t kFrameHeader = 64, kRecordRow = 32, kCountsHeader = 32, kCameraBytes = 0x390;
constexpr std::uint32_t kMostRecords = 1024;
constexpr std::size_t kMostFrames = 20'000;
constexpr std::uint16_t kCountsRecord = 1, kCameraRecord = 0x20;
constexpr std::string_view kPngStart = "\x89PNG\r\n\x1a\n", kJpegStart = "\xff\xd8\xff"sv;

/// Whole numbers and floats of bytes that are all there.
struct Packed {
  std::string bytes;
  bool big = false;

  std::uint32_t whole(std::size_t at, std::size_t size) const {
    std::uint32_t value = 0;
    for (std::size_t i = 0; i < size; ++i)
      value = value << 8U | static_cast<unsigned char>(bytes[at + (big ? i : size - 1 - i)]);
    return value;
  }
  double real(std::size_t at) const { return static_cast<double>(std::bit_cast<float>(whole(at, 4))); }
  std::string text(std::size_t at, std::size_t size) const {
    const std::string all = bytes.substr(at, size);
    return printable(trimmed(all.substr(0, all.find('\0'))), size);
  }
};

/// A file of FFF, or the one that lies in a JPEG.
class FlirBytes {
 public:
  FlirBytes(std::string path, std::istream& from, std::int64_t size)
      : path_(std::move(path)), from_(from), size_(size) {}

  [[noreturn]] void fail(const std::string& why) const {
    throw RuntimeError("cannot read " + path_ + ": damaged or incomplete FLIR image (" + why +
                       "); copy or export the file again");
  }
  std::int64_t size() const { return size_; }
  const std::string& path() const { return path_; }
  std::string at(std::int64_t begin, std::int64_t count, const char* what) const {
    if (begin < 0 || count < 0 || begin > size_ || count > size_ - begin)
      fail(std::string(what) + " from byte " + std::to_string(begin) + " to " + std::to_string(begin + count) +
           " lies beyond its " + std::to_string(size_) + " bytes");
    std::string bytes(static_cast<std::size_t>(count), '\0');
    from_.clear();
    from_.seekg(begin);
    if (!from_.read(bytes.data(), count)) fail(std::string(what) + " cannot be read");
    return bytes;
  }
  /// A record, in the order of bytes in which its first number is 2.
  Packed record(std::int64_t begin, std::int64_t count, const char* what) const {
    Packed packed{at(begin, count, what)};
    if (packed.whole(0, 2) != 2) packed.big = true;
    if (packed.whole(0, 2) != 2) fail(std::string(what) + " does not begin with the 2 that tells its order of bytes");
    return packed;
  }

 private:
  std::string path_;
  std::istream& from_;
  std::int64_t size_;
};

/// What the camera stores beside its counts. Constants of its counts that are not finite are not there.
void read_camera(const Packed& camera, std::map<std::string, std::string>& attributes) {
  const auto number = [&](const char* name, double value, const char* unit = "") {
    if (std::isfinite(value) || !std::string_view(name).starts_with("camera_counts."))
      attributes[name] = number_text(value) + unit;
  };
  number("camera_counts.R1", camera.real(0x58));
  number("camera_counts.B", camera.real(0x5c));
  number("camera_counts.F", camera.real(0x60));
  number("camera_counts.O", static_cast<std::int32_t>(camera.whole(0x308, 4)));
  number("camera_counts.R2", camera.real(0x30c));
  number("scene.emissivity", camera.real(0x20));
  number("scene.surroundings", camera.real(0x28), " K");
  number("flir.distance", camera.real(0x24), " m");
  number("flir.air_temperature", camera.real(0x2c), " K");
  number("flir.window_temperature", camera.real(0x30), " K");
  number("flir.window_transmission", camera.real(0x34));
  const double humidity = camera.real(0x3c);  // older cameras store a percentage
  number("flir.relative_humidity", humidity > 2.0 ? humidity / 100.0 : humidity);
  number("flir.alpha1", camera.real(0x70));
  number("flir.alpha2", camera.real(0x74));
  number("flir.beta1", camera.real(0x78));
  number("flir.beta2", camera.real(0x7c));
  number("flir.X", camera.real(0x80));
  number("flir.field_of_view", camera.real(0x1b4), " deg");
  for (const auto& [name, at, size] : {std::tuple{"flir.camera", 0xd4, 32},
                                       {"flir.serial_number", 0x104, 16},
                                       {"flir.lens", 0x170, 32},
                                       {"flir.filter", 0x1ec, 16}})
    if (std::string text = camera.text(static_cast<std::size_t>(at), static_cast<std::size_t>(size)); !text.empty())
      attributes[name] = std::move(text);
  const auto minutes = static_cast<std::int16_t>(camera.whole(0x38c, 2));  // by which UTC is later than the local time
  if (const std::uint32_t seconds = camera.whole(0x384, 4); seconds > 0) {
    const std::chrono::sys_seconds time(std::chrono::seconds{seconds});
    const auto day = std::chrono::floor<std::chrono::days>(time);
    const std::chrono::year_month_day date(day);
    const std::chrono::hh_mm_ss clock(time - day);
    std::array<char, 32> text{};
    std::snprintf(text.data(), text.size(), "%04d-%02u-%02uT%02d:%02d:%02dZ", static_cast<int>(date.year()),
                  static_cast<unsigned>(date.month()), static_cast<unsigned>(date.day()),
                  static_cast<int>(clock.hours().count()), static_cast<int>(clock.minutes().count()),
                  static_cast<int>(clock.seconds().count()));
    attributes["flir.time"] = std::string(text.data()) + ", local time " + number_text(-minutes / 60.0) + " h later";
  }
}

/// Sum of the differences of neighbours in a row, of the numbers in one order of bytes.
std::int64_t roughness(const std::vector<std::uint16_t>& counts, bool swapped) {
  std::int64_t sum = 0;
  const auto value = [&](std::size_t i) -> int {
    return swapped ? static_cast<std::uint16_t>(counts[i] << 8 | counts[i] >> 8) : counts[i];
  };
  for (std::size_t i = 1; i < counts.size(); ++i) sum += std::abs(value(i) - value(i - 1));
  return sum;
}

/// The counts of a PNG, the least byte first.
std::vector<char> unpacked_png(const std::string& path, const std::string& png, std::int64_t width,
                               std::int64_t height) {
  const std::string name = path + ", the PNG of its counts";
  std::istringstream stream(png);
  const auto size = static_cast<std::int64_t>(png.size());
  const RasterHeader header = scan_png(name, stream, size);
  if (header.width != width || header.height != height || header.colours != 1 || header.type != "uint16")
    throw RuntimeError("cannot read " + name + ": it has " + size_text(header.width, header.height) + " pixels of " +
                       header.type + " where " + size_text(width, height) + " of uint16 are announced");
  const std::vector<Image> planes = codecs().decode_png(name, stream, size, header);
  const Image& plane = planes.front();
  std::vector<std::uint16_t> counts(static_cast<std::size_t>(plane.size()));
  std::transform(plane.data(), plane.data() + plane.size(), counts.begin(),
                 [](float count) { return static_cast<std::uint16_t>(count); });
  const bool swap = roughness(counts, true) <= roughness(counts, false);
  std::vector<char> bytes;
  for (const std::uint16_t count : counts) {
    bytes.push_back(static_cast<char>(swap ? count >> 8 : count & 255));
    bytes.push_back(static_cast<char>(swap ? count & 255 : count >> 8));
  }
  return bytes;
}

/// What they are, and that their worth is not known where a constant is missing.
void state_counts(FileInfo& info) {
  info.attributes["mtf:quantity"] = "counts";
  for (const char* key : {"R1", "B", "F", "O", "R2"})
    if (!info.attributes.contains(std::string("camera_counts.") + key)) {
      info.notes.emplace_back(
          "the constants of its camera are not in it: what a count is worth is for [camera_counts] to say");
      return;
    }
}

RawImage dji_image(const std::string& path, const RasterHeader& header) {
  RawImage image;
  image.file = path;
  image.type = {'u', 2, false};
  image.planes.resize(1);
  for (const std::int64_t step : {1, 2}) {
    image.info.width = header.width / step;
    image.info.height = header.height / step;
    if (2 * image.info.width * image.info.height == std::ssize(header.dji)) break;
    if (step == 2)
      throw RuntimeError("cannot read " + path + ": " + std::to_string(header.dji.size()) +
                         " bytes of counts (DJI) beside a picture of " + size_text(header.width, header.height) +
                         " pixels: their columns and rows are not known");
  }
  image.info.format = Format::flir;
  image.info.storage = "16-bit of DJI";
  image.held.assign(header.dji.begin(), header.dji.end());
  // Pictures are turned upright, their counts may not be: of two shapes that in which neighbours down are more alike.
  const auto unlike = [&](std::int64_t width) {
    std::vector<float> counts(image.held.size() / 2);
    to_floats(image.type, image.held.data(), 2, {}, counts);
    double sum = 0.0;
    for (auto at = counts.begin() + width; at < counts.end(); ++at)
      sum += static_cast<double>(std::abs(*at - at[-width]));
    return sum / static_cast<double>((std::ssize(counts) - width) * width);  // of a ramp the same for all widths
  };
  if (std::int64_t& width = image.info.width, &height = image.info.height;
      width > 1 && height > 1 && unlike(height) < 0.7 * unlike(width)) {
    std::swap(width, height);
    image.info.notes.push_back("its counts lie in rows of " + std::to_string(width) + ", turned against the picture");
  }
  state_counts(image.info);
  interleave_pixels(image);
  name_channels(image, {"counts"});
  return image;
}

/// The FFF that begins at `begin`, whose end is told; nothing where it has no counts.
std::optional<RawImage> frame_of(const FlirBytes& file, std::int64_t begin, bool in_jpeg, std::int64_t& end) {
  Packed header{file.at(begin, kFrameHeader, "a header")};
  constexpr std::uint32_t least_version = 100, most_version = 199;
  const auto known = [&] { return header.whole(20, 4) >= least_version && header.whole(20, 4) <= most_version; };
  if (!known()) header.big = true;
  if (!known()) file.fail("the version of its header is none from 100 to 199");
  const std::uint32_t place = header.whole(24, 4), count = header.whole(28, 4);
  if (count > kMostRecords) file.fail(std::to_string(count) + " records are announced");
  const Packed rows{file.at(begin + place, count * kRecordRow, "the list of records"), header.big};
  end = std::max(begin + kFrameHeader, begin + place + count * kRecordRow);

  RawImage image;
  FileInfo& info = image.info;
  std::optional<std::pair<std::int64_t, std::int64_t>> counts;
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t row = i * static_cast<std::size_t>(kRecordRow);
    const std::uint32_t type = rows.whole(row, 2);
    const std::int64_t at = begin + rows.whole(row + 12, 4), size = rows.whole(row + 16, 4);
    if (type == 0) continue;  // a place that is free
    if (at > file.size() || size > file.size() - at)
      file.fail("record " + std::to_string(i + 1) + " of type " + std::to_string(type) + " ends at byte " +
                std::to_string(at + size) + " of " + std::to_string(file.size()));
    end = std::max(end, at + size);
    if (type == kCountsRecord && !counts) counts = {at, size};
    if (type == kCameraRecord && size >= kCameraBytes && info.attributes.empty())
      read_camera(file.record(at, kCameraBytes, "the record of the camera"), info.attributes);
  }
  if (!counts) return std::nullopt;
  const auto [at, size] = *counts;
  if (size < kCountsHeader + 2) file.fail("the record of its counts holds none");
  const Packed geometry = file.record(at, kCountsHeader, "the record of its counts");
  info.format = Format::flir;
  info.width = geometry.whole(2, 2);
  info.height = geometry.whole(4, 2);
  image.type = {'u', 2, geometry.big};
  image.planes.resize(1);
  check_plane_pixels(file.path(), info.width, info.height);
  const std::int64_t first = at + kCountsHeader, bytes = size - kCountsHeader;
  const std::string start = file.at(first, std::min<std::int64_t>(bytes, 8), "the counts");
  image.file = file.path();
  info.storage = geometry.big ? "16-bit, greatest byte first" : "16-bit, least byte first";
  const bool jpeg_ls = start.starts_with(kJpegStart);
  if (jpeg_ls && codecs().decode_jpeg_ls == nullptr)
    throw RuntimeError(
        "cannot read " + file.path() +
        ": its counts are JPEG-LS (CSQ), which this build does not read: build it with libcharls-dev, or "
        "export them as SEQ, TIFF or radiometric JPEG with FLIR's software");
  if (start == kPngStart || jpeg_ls) {
    info.storage = jpeg_ls ? "16-bit JPEG-LS" : "16-bit PNG";
    image.type.big_endian = jpeg_ls && std::endian::native == std::endian::big;
    // Of a file it is read when it is asked for: a sequence need not fit memory.
    image.unpack = [path = file.path(), held = in_jpeg ? file.at(first, bytes, "the counts") : std::string(), first,
                    bytes, width = info.width, height = info.height, jpeg_ls] {
      check_plane_size(path, width, height, 2);
      std::ifstream again(path, std::ios::binary);
      const std::string packed =
          held.empty() ? FlirBytes(path, again, first + bytes).at(first, bytes, "the counts") : held;
      return jpeg_ls ? codecs().decode_jpeg_ls(path, packed, width, height) : unpacked_png(path, packed, width, height);
    };
  } else {
    const std::int64_t needed = 2 * info.width * info.height;
    if (needed > bytes)
      file.fail(size_text(info.width, info.height) + " counts need " + std::to_string(needed) +
                " bytes and its record has " + std::to_string(bytes));
    if (in_jpeg) {
      const std::string all = file.at(first, needed, "the counts");
      image.held.assign(all.begin(), all.end());
    } else {
      image.begin = first;
    }
  }
  state_counts(info);
  return image;
}

}  // namespace

std::vector<RawImage> open_flir(const std::string& path, Part) {
  const std::int64_t file_size = input_file_size(path);
  std::ifstream file(path, std::ios::binary);
  std::array<char, 3> start{};
  const bool in_jpeg = file.read(start.data(), start.size()) && std::string_view(start.data(), 3) == kJpegStart;
  const RasterHeader header = in_jpeg ? scan_jpeg(path) : RasterHeader{};
  std::vector<RawImage> images;
  if (!header.dji.empty()) {
    images.push_back(dji_image(path, header));
    return images;
  }
  std::istringstream segments(header.flir);
  const FlirBytes from(path, in_jpeg ? static_cast<std::istream&>(segments) : file,
                       in_jpeg ? std::ssize(header.flir) : file_size);
  std::size_t without = 0;
  std::int64_t at = 0;
  const auto is_frame = [&] {
    const std::string mark = from.size() - at >= kFrameHeader ? from.at(at, 4, "a header") : std::string();
    return mark == "FFF\0"sv || mark == "AFF\0"sv;
  };
  while (is_frame()) {
    if (images.size() == kMostFrames)
      from.fail("more than " + std::to_string(kMostFrames) + " frames; cut it in parts");
    std::int64_t end = at;
    if (std::optional<RawImage> image = frame_of(from, at, in_jpeg, end)) {
      interleave_pixels(*image);
      name_channels(*image, {"counts"}, static_cast<int>(images.size()));
      images.push_back(std::move(*image));
    } else {
      ++without;
    }
    at = end;
  }
  if (images.empty()) from.fail(without > 0 ? "no record of counts" : "no header of FFF where one belongs");
  std::vector<std::string>& notes = images.front().info.notes;
  if (without > 0) notes.push_back(plural(static_cast<std::int64_t>(without), "frame") + " of it without counts");
  if (at < from.size())
    notes.push_back(plural(from.size() - at, "byte") + " of " + std::to_string(from.size()) +
                    " behind the last frame are not read");
  return images;
}

}  // namespace mtf::io
