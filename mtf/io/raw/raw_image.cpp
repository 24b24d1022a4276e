// SPDX-License-Identifier: Apache-2.0
#include "mtf/io/raw/raw_image.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <system_error>
#include <utility>

#include "mtf/error.h"
#include "mtf/io/channel_choice.h"
#include "mtf/io/file_checks.h"
#include "mtf/words.h"

namespace mtf::io {
namespace {

[[noreturn]] void fail_to_read(const std::string& file, const std::string& why) {
  throw RuntimeError("cannot read " + file + ": " + why + "; copy or export the file again");
}

}  // namespace

std::int64_t check_samples(const std::string& path, const RawImage& image, std::int64_t begin, std::int64_t planes,
                           std::int64_t row_padding) {
  const auto& [width, height] = std::pair{image.info.width, image.info.height};
  check_plane_pixels(path, width, height);
  const std::int64_t size = input_file_size(image.file);
  const double row =
      static_cast<double>(width) * static_cast<double>(planes) * image.type.bytes + static_cast<double>(row_padding);
  const double end = static_cast<double>(begin) + row * static_cast<double>(height);
  if (planes < 1) throw RuntimeError(path + ": the image has no planes; export the file again");
  if (begin < 0 || end > static_cast<double>(size))
    throw RuntimeError(path + ": its header announces " + size_text(width, height) + " pixels, " +
                       plural(planes, "plane") + " of " + image.type.name() + " from byte " + std::to_string(begin) +
                       " to " + fixed(end, 0) + ", and " + (image.file == path ? "the file" : image.file) + " has " +
                       std::to_string(size) + " bytes: it is cut off, or the header is that of another file; copy or " +
                       "export it again");
  return size - static_cast<std::int64_t>(end);
}

void interleave_pixels(RawImage& image, std::int64_t row_padding) {
  image.plane_step = image.type.bytes;
  image.pixel_step = image.plane_step * std::ssize(image.planes);
  image.row_step = image.pixel_step * image.info.width + row_padding;
}

void name_channels(RawImage& image, const std::vector<std::string>& names, int part) {
  FileInfo& info = image.info;
  info.display_window = {0, 0, static_cast<int>(info.width - 1), static_cast<int>(info.height - 1)};
  info.data_window = info.display_window;
  std::string type = image.type.name();
  const auto is_scaled = [](const Meaning& plane) { return plane.gain != 1.0 || plane.offset != 0.0; };
  if (!image.type.is_float() && std::ranges::any_of(image.planes, is_scaled)) type += " as float";
  for (const std::string& name : names) {
    ChannelInfo& channel = info.channels.emplace_back();
    channel.name = name;
    channel.type = type;
    channel.part = part;
  }
}

void set_no_data(RawImage& image, double value, const std::string& words) {
  for (Meaning& plane : image.planes) plane.no_data = value;
  note_no_data(image.info, words);
}

FileInfo read_raw_info(const std::string& path, OpenRaw open, Part part) {
  const std::vector<RawImage> images = open(path, part);
  const auto of_part =
      std::ranges::find_if(images, [&](const RawImage& image) { return image.info.channels.front().part == part; });
  FileInfo info = of_part == images.end() ? images.front().info : of_part->info;
  info.channels.clear();
  for (const RawImage& image : images)
    info.channels.insert(info.channels.end(), image.info.channels.begin(), image.info.channels.end());
  return info;
}

RawWindows::RawWindows(const std::string& path, OpenRaw open, const ReadOptions& options) {
  std::vector<RawImage> images = open(path, options.part);
  std::vector<ChannelInfo> all;
  for (const RawImage& image : images) all.insert(all.end(), image.info.channels.begin(), image.info.channels.end());
  ChannelChoice choice = choose_channels(path, all, options);
  std::size_t before = 0;  // channels of other images
  auto image = images.begin();
  for (; choice.indices.front() >= before + image->planes.size(); ++image) before += image->planes.size();
  image_ = std::move(*image);
  for (const std::size_t index : choice.indices) chosen_.push_back(static_cast<std::int64_t>(index - before));
  file_.names = std::move(choice.names);
  file_.info = image_.info;
  file_.info.channels = std::move(all);
  const std::string& type = image_.info.channels.front().type;
  // Numbers whose quantity the file states are of its unit as they are.
  file_.integer =
      !type.ends_with("float") && !type.ends_with("double") && !image_.info.attributes.contains("mtf:quantity");
  if (image_.unpack) image_.held = image_.unpack();
  if (image_.decode) return;
  descriptor_ = ::open(image_.file.c_str(), O_RDONLY | O_CLOEXEC);
  if (descriptor_ < 0)
    throw RuntimeError("cannot read " + image_.file + ": " + std::generic_category().message(errno) +
                       "; check its permissions");
}

RawWindows::~RawWindows() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

void RawWindows::note_rounding() {
  const auto plain = [](const Meaning& plane) { return plane.gain == 1.0 && plane.offset == 0.0; };
  const NumberType& type = image_.type;
  if ((type.bytes < 4 || (type.bytes == 4 && type.is_float())) && std::ranges::all_of(image_.planes, plain)) return;
  const auto& [width, height] = std::pair{image_.info.width, image_.info.height};
  constexpr std::int64_t together = 1 << 20;
  Image strip(width, std::clamp(together / width, std::int64_t{1}, height));
  for (std::size_t c = 0; c < chosen_.size(); ++c) {
    Rounding rounding;
    for (std::int64_t y = 0; y < height; y += strip.height()) {
      ImageView<float> view = strip.view();
      view.height = std::min(view.height, height - y);
      read(c, 0, y, {&view, 1}, {&rounding, 1});
    }
    rounding.note(image_.file, file_.names[c], file_.info.notes);
  }
}

void RawWindows::read(std::size_t first_channel, std::int64_t x, std::int64_t y, std::span<const ImageView<float>> out,
                      std::span<Rounding> rounding) const {
  const std::span planes = std::span(chosen_).subspan(first_channel, out.size());
  if (image_.decode) {
    for (std::size_t c = 0; c < out.size(); ++c)
      image_.decode(planes[c], x, y, out[c], rounding.empty() ? nullptr : &rounding[c]);
    return;
  }
  const std::int64_t width = out.front().width;
  std::vector<char> bytes;
  std::int64_t from = 0;
  const auto fetch = [&](std::int64_t row, std::int64_t least_plane, std::int64_t most_plane) {
    from = image_.begin + row * image_.row_step + x * image_.pixel_step +
           std::min(least_plane * image_.plane_step, most_plane * image_.plane_step);
    bytes.resize(static_cast<std::size_t>((width - 1) * image_.pixel_step +
                                          (most_plane - least_plane) * std::abs(image_.plane_step) +
                                          image_.type.bytes));
    if (!image_.held.empty()) {
      std::copy_n(image_.held.begin() + from, bytes.size(), bytes.begin());
      return;
    }
    for (std::size_t done = 0; done < bytes.size();) {
      const ssize_t got =
          ::pread(descriptor_, bytes.data() + done, bytes.size() - done, from + static_cast<std::int64_t>(done));
      if (got < 0 && errno == EINTR) continue;
      if (got < 0) fail_to_read(image_.file, std::generic_category().message(errno));
      if (got == 0) fail_to_read(image_.file, "it has become shorter");
      done += static_cast<std::size_t>(got);
    }
  };
  const bool together = std::abs(image_.plane_step) < image_.pixel_step;  // a pixel holds all planes
  const auto [least, most] = std::ranges::minmax(planes);
  for (std::int64_t row = 0; row < out.front().height; ++row) {
    if (together) fetch(y + row, least, most);
    for (std::size_t c = 0; c < out.size(); ++c) {
      if (!together) fetch(y + row, planes[c], planes[c]);
      const std::int64_t at =
          image_.begin + (y + row) * image_.row_step + x * image_.pixel_step + planes[c] * image_.plane_step - from;
      const std::span to(out[c].row(row), static_cast<std::size_t>(width));
      to_floats(image_.type, bytes.data() + at, image_.pixel_step, image_.planes[static_cast<std::size_t>(planes[c])],
                to, rounding.empty() ? nullptr : &rounding[c]);
      if (image_.info.format == Format::pnm && static_cast<double>(std::ranges::max(to)) > image_.info.largest)
        fail_to_read(image_.file, "a sample of row " + std::to_string(y + row) +
                                      " is above the largest value that the header states");
    }
  }
}

ImageFile read_raw(const std::string& path, OpenRaw open, const ReadOptions& options) {
  const RawWindows windows(path, open, options);
  ImageFile image{
      .names = windows.file().names, .planes = {}, .integer = windows.file().integer, .info = windows.file().info};
  const std::int64_t width = image.info.width, height = image.info.height;
  check_plane_size(path, width, height, std::ssize(image.names));
  std::vector<ImageView<float>> views;
  for (std::size_t i = 0; i < image.names.size(); ++i) image.planes.emplace_back(width, height);
  for (Image& plane : image.planes) views.push_back(plane.view());
  std::vector<Rounding> rounding(views.size());
  windows.read(0, 0, 0, views, rounding);
  for (std::size_t i = 0; i < views.size(); ++i) rounding[i].note(path, image.names[i], image.info.notes);
  return image;
}

}  // namespace mtf::io
