// SPDX-License-Identifier: Apache-2.0
#include "apps/image/image_facts.h"

#include <algorithm>
#include <filesystem>

#include "apps/terminal/output.h"
#ifdef MTFKIT_HAVE_CALIB
#include "calib/find/find_edges.h"
#endif
#include "mtf/error.h"
#include "mtf/io/channel_choice.h"
#include "mtf/io/exr/spectral_exr.h"
#include "mtf/io/scene.h"

namespace apps {
namespace {

using mtf::io::ChannelInfo;
using mtf::io::FileInfo;
using mtf::io::ReadOptions;

/// A channel by channel pass decodes the whole file each time: samples decoded, about a minute.
constexpr double kMostSamples = 4e9;

bool is_float(const ChannelInfo& channel) {
  const std::string& type = channel.type;
  return type.ends_with("half") || type.ends_with("float") || type.ends_with("double");
}

bool is_radiance(const ChannelInfo& channel) {
  const auto spectral = mtf::io::parse_spectral_channel(channel.name);
  return spectral && spectral->kind == mtf::io::SpectralChannel::Kind::stokes;
}

std::string meaning(const FileInfo& info) {
  const auto stated = [&](const char* name) {
    const auto found = info.attributes.find(name);
    return found == info.attributes.end() ? std::string() : one_line(found->second);
  };
  const std::string quantity = stated("mtf:quantity"), units = stated("mtf:units");
  if (!quantity.empty() || !units.empty())
    return (quantity.empty() ? "quantity not stated" : quantity) + (units.empty() ? "" : " in " + units) +
           " (stated in the file)";
  if (const std::string foreign = stated("emissiveUnits"); !foreign.empty())
    return "emissiveUnits " + foreign + " (stated in the file); [scene] of the sensor file says what it is taken for";
  if (std::any_of(info.channels.begin(), info.channels.end(), is_radiance))
    return "spectral radiance by the names of its channels; unit not stated: W.m^-2.sr^-1.nm^-1 assumed, unless "
           "[scene] of the sensor file gives a gain";
  if (std::none_of(info.channels.begin(), info.channels.end(), is_float))
    return "whole numbers, unit not stated: [scene] of the sensor file has to give gain, offset and quantity";
  return "not stated: radiance assumed, W.m^-2.sr^-1, unless [scene] of the sensor file gives another quantity";
}

/// What the file says of the curve of its values, and who follows it.
std::string encoding_remark(const FileInfo& info) {
  const auto& [word, source] = info.encoding;
  if (source.empty()) return "";
  if (word == "linear") return source + ": the values are linear";
  if (word.empty())
    return source +
           " is not applied: measure and fit take the values as linear unless --encoding says their curve, "
           "simulate asks for [scene] encoding";
  return source + ": the values follow the curve " + word +
         "; measure and fit undo it (--encoding linear: not), simulate asks for [scene] encoding";
}

void measure(ChannelFacts& facts, const mtf::Image& plane) {
  const mtf::Statistics s = mtf::statistics(plane.view());
  facts.statistics = s;
  if (s.not_finite >= plane.size()) return;
  facts.min = s.min;
  facts.max = s.max;
  facts.mean = s.mean;
  facts.std = s.std;
}

bool can_be_read(const ChannelInfo& channel) {
  return channel.x_sampling == 1 && channel.y_sampling == 1 && !channel.type.starts_with("deep");
}

void measure_raster(ImageFacts& facts, const InfoOptions& options) {
  const mtf::io::ImageFile image =
      mtf::io::read_image(options.file, {.channel = options.channel, .layer = options.layer, .part = options.part});
  for (std::size_t i = 0; i < image.names.size(); ++i)
    for (ChannelFacts& channel : facts.channels)
      if (channel.channel.name == image.names[i]) measure(channel, image.planes[i]);
}

void measure_exr(ImageFacts& facts, const InfoOptions& options) {
  const FileInfo& info = facts.info;
  const double pixels = static_cast<double>(info.width) * static_cast<double>(info.height);
  const auto count = static_cast<double>(info.channels.size());
  if (pixels * count * static_cast<double>(facts.channels.size()) > kMostSamples) {
    facts.remarks.push_back("no statistics: the file is large; choose one channel with --channel NAME");
    return;
  }
  std::int64_t missing = 0;
  std::size_t unreadable = 0;
  for (ChannelFacts& channel : facts.channels) {
    if (!can_be_read(channel.channel)) {
      ++unreadable;
      continue;
    }
    const ReadOptions read{.channel = channel.channel.name, .layer = {}, .part = channel.channel.part};
    const mtf::io::ImageFile image = mtf::io::read_image(options.file, read);
    missing = std::max(missing, image.missing_pixels);
    measure(channel, image.planes.front());
  }
  if (unreadable > 0)
    facts.remarks.push_back(std::to_string(unreadable) +
                            " channels are deep (several samples a pixel) or subsampled and cannot be read; "
                            "flatten the image, or choose a channel at full resolution");
  if (missing > 0)
    facts.remarks.push_back(std::to_string(missing) + " pixels lie outside the data window and count as 0");
}

/// The shortest choice that reads an image from the file; nothing when there is none. Channels one by one come last.
std::optional<ReadOptions> choice_of(const std::string& path, const FileInfo& info, const InfoOptions& options) {
  const auto works = [&](const ReadOptions& read) {
    try {
      static_cast<void>(mtf::io::choose_channels(path, info.channels, read));
      return true;
    } catch (const mtf::UsageError&) {
      return false;
    }
  };
  std::vector<ReadOptions> tries;
  const ReadOptions asked{.channel = options.channel, .layer = options.layer, .part = options.part};
  tries.push_back(asked);
  if (!asked.channel) {
    for (const ChannelInfo& c : info.channels) tries.push_back({.channel = {}, .layer = c.layer, .part = asked.part});
    for (const ChannelInfo& c : info.channels) tries.push_back({.channel = {}, .layer = {}, .part = c.part});
    for (const ChannelInfo& c : info.channels) tries.push_back({.channel = {}, .layer = c.layer, .part = c.part});
    for (const ChannelInfo& c : info.channels) tries.push_back({.channel = c.name, .layer = {}, .part = c.part});
  }
  constexpr std::size_t most = 400;
  for (std::size_t i = 0; i < std::min(tries.size(), most); ++i)
    if (works(tries[i])) return tries[i];
  return std::nullopt;
}

/// As options of the command.
std::string words_of(const ReadOptions& read) {
  return (read.part ? " --part " + std::to_string(*read.part) : "") +
         (read.layer ? " --layer " + shell_word(*read.layer) : "") +
         (read.channel ? " --channel " + shell_word(*read.channel) : "");
}

/// An image of one channel that an edge crosses was made to be measured.
bool shows_one_edge([[maybe_unused]] const std::string& path, [[maybe_unused]] const FileInfo& info,
                    [[maybe_unused]] const ReadOptions& read) {
#ifdef MTFKIT_HAVE_CALIB
  constexpr double kMostPixels = 4e6;
  if (static_cast<double>(info.width) * static_cast<double>(info.height) > kMostPixels) return false;
  const mtf::io::ImageFile image = mtf::io::read_image(path, read);
  if (image.planes.size() != 1) return false;
  const mtf::Image& plane = image.planes.front();
  const calib::FoundEdges found = calib::find_edges(plane.view());
  return found.edges.size() == 1 && found.edges.front().roi == calib::Roi{0, 0, plane.width(), plane.height()};
#else
  return false;
#endif
}

}  // namespace

ImageFacts image_facts(const InfoOptions& options) {
  ImageFacts facts;
  facts.path = options.file;
  facts.info = mtf::io::read_info(options.file);
  facts.values = meaning(facts.info);
  facts.remarks = facts.info.notes;
  for (std::string remark : {encoding_remark(facts.info), mtf::io::aspect_note(facts.info)})
    if (!remark.empty()) facts.remarks.push_back(std::move(remark));
  const bool narrowed = options.channel || options.layer || options.part;
  for (const ChannelInfo& channel : facts.info.channels) {
    const bool in_layer = !options.layer || channel.layer == *options.layer ||
                          (channel.layer.empty() && channel.part_name == *options.layer);
    const bool named = !options.channel || channel.name == *options.channel ||
                       (options.layer && mtf::io::base_of(channel.name) == *options.channel);
    if (in_layer && named && (!options.part || channel.part == *options.part))
      facts.channels.push_back({channel, {}, {}, {}, {}, {}});
  }
  // The refusal of the reader lists what there is.
  if (facts.channels.empty() && narrowed)
    static_cast<void>(mtf::io::choose_channels(
        options.file, facts.info.channels, {.channel = options.channel, .layer = options.layer, .part = options.part}));
  if (facts.info.format == mtf::io::Format::exr)
    measure_exr(facts, options);
  else
    measure_raster(facts, options);
  if (const std::optional<ReadOptions> read = choice_of(options.file, facts.info, options)) {
    const std::string file = shell_word(options.file) + words_of(*read);
    const bool taken = std::filesystem::path(options.file).filename() == "out.exr";
    facts.next = shows_one_edge(options.file, facts.info, *read)
                     ? "mtf measure " + file
                     : "mtf simulate sensor.toml " + file + (taken ? " -o out2.exr" : " -o out.exr");
  }
  return facts;
}

}  // namespace apps
