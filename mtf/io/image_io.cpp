// SPDX-License-Identifier: Apache-2.0
#include "mtf/io/image_io.h"

#include <fstream>
#include <utility>

#include "mtf/error.h"
#include "mtf/io/channel_choice.h"
#include "mtf/io/codecs/codecs.h"
#include "mtf/io/codecs/raster_scan.h"
#include "mtf/io/exr/exr_read.h"
#include "mtf/io/file_checks.h"
#include "mtf/words.h"

namespace mtf::io {
namespace {

RasterHeader raster_header(const std::string& path, Format format) {
  if (format == Format::png) return scan_png(path);
  return format == Format::jpeg ? scan_jpeg(path) : codecs().tiff_header(path, input_file_size(path));
}

FileInfo describe(const RasterHeader& header, Format format) {
  FileInfo info;
  info.format = format;
  info.storage = header.storage;
  info.width = header.width;
  info.height = header.height;
  info.display_window = {0, 0, static_cast<int>(header.width) - 1, static_cast<int>(header.height) - 1};
  info.data_window = info.display_window;
  info.attributes = header.attributes;
  info.encoding = header.encoding;
  info.dct_steps = header.dct_steps;
  info.pixel_aspect = header.pixel_aspect;
  info.notes = header.notes;
  if (header.no_data) {
    info.no_data = header.no_data->words;
    info.notes.push_back("pixels of the value " + info.no_data + " are no data and read as NaN");
  }
  std::vector<std::string> names{"Y"};
  if (header.colours == 3) names = {"R", "G", "B"};
  if (header.alpha) names.emplace_back("A");
  for (const std::string& name : names) {
    ChannelInfo channel;
    channel.name = name;
    channel.type = header.type;
    info.channels.push_back(channel);
  }
  return info;
}

std::vector<Image> decode_raster(const std::string& path, Format format, const RasterHeader& header) {
  if (format == Format::png) return codecs().decode_png(path, header);
  return format == Format::jpeg ? codecs().decode_jpeg(path, header) : codecs().decode_tiff(path, header);
}

ImageFile read_raster(const std::string& path, Format format, const ReadOptions& options) {
  const RasterHeader header = raster_header(path, format);
  ImageFile image;
  image.info = describe(header, format);
  if (format == Format::jpeg && options.channel && *options.channel != "Y")
    throw UsageError(path +
                     ": of a JPEG only the luminance plane Y is read: its colours are mixed and mostly of fewer "
                     "pixels; leave out the choice of a channel, or measure the raw image");
  const ChannelChoice choice = choose_channels(path, image.info.channels, options);
  for (const std::size_t i : choice.indices)
    if (image.info.channels[i].name == "A")
      throw UsageError(path + ": the alpha channel is not image data; choose Y or R, G, B");
  check_plane_size(path, header.width, header.height, header.colours);
  std::vector<Image> planes = decode_raster(path, format, header);
  for (const std::size_t i : choice.indices) image.planes.push_back(std::move(planes.at(i)));
  image.names = choice.names;
  image.integer = header.type == "uint8" || header.type == "uint16";
  return image;
}

}  // namespace

std::optional<Format> format_of(std::string_view start) {
  using std::string_view_literals::operator""sv;
  if (start.starts_with("\x76\x2f\x31\x01"sv)) return Format::exr;
  if (start.starts_with("\x89PNG\r\n\x1a\n"sv)) return Format::png;
  if (start.starts_with("\xff\xd8\xff"sv)) return Format::jpeg;
  for (const std::string_view tiff : {"II\x2a\0"sv, "MM\0\x2a"sv, "II\x2b\0"sv, "MM\0\x2b"sv})
    if (start.starts_with(tiff)) return Format::tiff;
  return std::nullopt;
}

Format detect_format(const std::string& path) {
  const std::int64_t size = input_file_size(path);
  std::ifstream file(path, std::ios::binary);
  if (!file) throw RuntimeError("cannot read " + path + ": it cannot be opened; check its permissions");
  std::array<char, 8> start{};
  file.read(start.data(), static_cast<std::streamsize>(start.size()));
  if (const auto format = format_of({start.data(), static_cast<std::size_t>(file.gcount())})) return *format;
  throw RuntimeError("cannot read " + path + ": its content (" + shown_bytes(static_cast<double>(size)) +
                     ") is neither OpenEXR nor PNG nor TIFF nor JPEG; convert the image to one of them");
}

Format format_from_extension(const std::string& path) {
  const auto slash = path.rfind('/');
  const std::string name = slash == std::string::npos ? path : path.substr(slash + 1);
  const auto dot = name.rfind('.');
  const std::string extension = dot == std::string::npos ? "" : lower_case(name.substr(dot));
  if (extension == ".exr") return Format::exr;
  if (extension == ".png") return Format::png;
  if (extension == ".tif" || extension == ".tiff") return Format::tiff;
  throw UsageError("cannot tell the image format of " + path + "; end the name in .exr, .png, .tif or .tiff");
}

FileInfo read_info(const std::string& path) {
  const Format format = detect_format(path);
  return format == Format::exr ? read_exr_info(path) : describe(raster_header(path, format), format);
}

ImageFile read_image(const std::string& path, const ReadOptions& options) {
  const Format format = detect_format(path);
  return format == Format::exr ? read_exr(path, options) : read_raster(path, format, options);
}

}  // namespace mtf::io
