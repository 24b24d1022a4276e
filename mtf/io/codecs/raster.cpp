// SPDX-License-Identifier: Apache-2.0
#include "mtf/io/codecs/raster.h"

#include <fstream>
#include <utility>

#include "mtf/error.h"
#include "mtf/io/channel_choice.h"
#include "mtf/io/codecs/codecs.h"
#include "mtf/io/codecs/raster_scan.h"
#include "mtf/io/file_checks.h"
#include "mtf/io/raw/raw_image.h"
#include "mtf/words.h"

namespace mtf::io {
namespace {

RasterHeader raster_header(const std::string& path, Format format, int page) {
  if (format == Format::png) return scan_png(path);
  return format == Format::jpeg ? scan_jpeg(path) : codecs().tiff_header(path, input_file_size(path), page);
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
  info.largest = header.largest;
  info.notes = header.notes;
  if (header.no_data) note_no_data(info, header.no_data->words);
  std::vector<std::string> names{"Y"};
  if (header.colours == 3) names = {"R", "G", "B"};
  if (header.alpha) names.emplace_back("A");
  for (const std::string& name : names) {
    ChannelInfo channel;
    channel.name = name;
    channel.type = header.type;
    channel.part = header.page;
    info.channels.push_back(channel);
  }
  return info;
}

/// A JPEG is a picture of the counts of a thermal camera, where it holds them: they are another image beside it. Where
/// they cannot be read the picture still can.
void add_counts(const std::string& path, const RasterHeader& header, FileInfo& info) {
  if (header.flir.empty() && header.dji.empty()) return;
  try {
    const FileInfo counts = read_raw_info(path, open_flir);
    info.channels.push_back(counts.channels.front());
    info.channels.back().part = 1;
    info.attributes.insert(counts.attributes.begin(), counts.attributes.end());
    info.attributes.erase("mtf:quantity");  // of the counts alone
    info.notes.push_back("it is a picture of the raw counts of a thermal camera, " +
                         size_text(counts.width, counts.height) + ", which it holds too: --channel counts reads them");
    info.notes.insert(info.notes.end(), counts.notes.begin(), counts.notes.end());
  } catch (const Error& error) {
    info.notes.push_back("the raw counts of a thermal camera that it holds are not readable: " +
                         std::string(error.what()));
  }
}

std::vector<Image> decode_raster(const std::string& path, Format format, RasterHeader& header) {
  if (format == Format::png) {
    std::ifstream file(path, std::ios::binary);
    return codecs().decode_png(path, file, input_file_size(path), header);
  }
  return format == Format::jpeg ? codecs().decode_jpeg(path, header) : codecs().decode_tiff(path, header);
}

}  // namespace

FileInfo read_raster_info(const std::string& path, Format format, int page) {
  const RasterHeader header = raster_header(path, format, page);
  FileInfo info = describe(header, format);
  add_counts(path, header, info);
  return info;
}

ImageFile read_raster(const std::string& path, Format format, const ReadOptions& options) {
  RasterHeader header = raster_header(path, format, options.part.value_or(0));
  ImageFile image;
  image.info = describe(header, format);
  if (options.channel == "counts" && !(header.flir.empty() && header.dji.empty()))
    return read_raw(path, open_flir, {.channel = {}, .layer = {}, .part = 0});
  add_counts(path, header, image.info);
  if (format == Format::jpeg && options.channel == "counts")
    for (const std::string& note : header.notes)
      if (note.find("raw counts of the camera") != std::string::npos) throw RuntimeError(path + ": " + note);
  if (format == Format::jpeg && options.channel && *options.channel != "Y")
    throw UsageError(path +
                     ": of a JPEG only the luminance plane Y is read: its colours are mixed and mostly of fewer "
                     "pixels; leave out the choice of a channel, or measure the raw image");
  const ChannelChoice choice = choose_channels(path, image.info.channels, options);
  if (choice.names.front() == "counts") return read_raw(path, open_flir, {.channel = {}, .layer = {}, .part = 0});
  for (const std::size_t i : choice.indices)
    if (image.info.channels[i].name == "A")
      throw UsageError(path + ": the alpha channel is not image data; choose Y or R, G, B");
  check_plane_size(path, header.width, header.height, header.colours);
  const auto noted = std::ssize(header.notes);
  std::vector<Image> planes = decode_raster(path, format, header);
  image.info.notes.insert(image.info.notes.end(), header.notes.begin() + noted, header.notes.end());
  for (const std::size_t i : choice.indices) image.planes.push_back(std::move(planes.at(i)));
  image.names = choice.names;
  image.integer = header.type != "float" && header.type != "double";
  return image;
}

}  // namespace mtf::io
