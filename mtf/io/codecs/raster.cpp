// SPDX-License-Identifier: Apache-2.0
#include "mtf/io/codecs/raster.h"

#include <utility>

#include "mtf/error.h"
#include "mtf/io/channel_choice.h"
#include "mtf/io/codecs/codecs.h"
#include "mtf/io/codecs/raster_scan.h"
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
  if (header.no_data) note_no_data(info, header.no_data->words);
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

}  // namespace

FileInfo read_raster_info(const std::string& path, Format format) {
  return describe(raster_header(path, format), format);
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

}  // namespace mtf::io
