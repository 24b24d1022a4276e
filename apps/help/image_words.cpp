// SPDX-License-Identifier: Apache-2.0
#include "apps/help/image_words.h"

#include <algorithm>
#include <filesystem>

#include "mtf/io/image_io.h"

namespace apps {
namespace {

using Words = std::vector<std::string>;

template <class Of>
Words of_channels(const Words& line, Of of) {
  Words found;
  for (const std::string& word : line) {
    std::error_code error;
    if (!std::filesystem::is_regular_file(word, error)) continue;
    try {
      // Of other formats the headers tell no layers, and need the module of codecs.
      if (mtf::io::detect_format(word) != mtf::io::Format::exr) continue;
      for (const mtf::io::ChannelInfo& channel : mtf::io::read_info(word).channels) found.push_back(of(channel));
    } catch (const std::exception&) {  // the command itself will say so
    }
  }
  std::erase(found, "");
  std::ranges::sort(found);
  found.erase(std::unique(found.begin(), found.end()), found.end());
  return found;
}

}  // namespace

Words channels_on(const Words& line) {
  return of_channels(line, [](const mtf::io::ChannelInfo& channel) { return channel.name; });
}

Words layers_on(const Words& line) {
  return of_channels(line, [](const mtf::io::ChannelInfo& channel) {
    return channel.layer.empty() ? channel.part_name : channel.layer;
  });
}

Words parts_on(const Words& line) {
  return of_channels(line, [](const mtf::io::ChannelInfo& channel) { return std::to_string(channel.part); });
}

}  // namespace apps
