// SPDX-License-Identifier: Apache-2.0
#include "mtf/io/channel_choice.h"

#include <algorithm>
#include <cctype>
#include <map>
#include <utility>

#include "mtf/error.h"
#include "mtf/io/exr/spectral_exr.h"
#include "mtf/words.h"

namespace mtf::io {
namespace {

using Indices = std::vector<std::size_t>;

std::string upper(std::string text) {
  for (char& c : text) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  return text;
}

Indices without_alpha(const std::vector<ChannelInfo>& channels, Indices group) {
  std::erase_if(group, [&](std::size_t i) {
    const std::string base = upper(base_of(channels[i].name));
    return base == "A" || base == "ALPHA";
  });
  return group;
}

std::string listed(const std::vector<ChannelInfo>& channels) {
  if (channels.empty()) return "it has no channels";
  constexpr std::size_t shown = 40;
  const bool parts = std::any_of(channels.begin(), channels.end(), [](const ChannelInfo& c) { return c.part != 0; });
  std::string text = "it has ";
  for (std::size_t i = 0; i < std::min(channels.size(), shown); ++i) {
    const ChannelInfo& c = channels[i];
    text += (i ? ", " : "") + printable(c.name, 80) + " (" + c.type;
    if (c.x_sampling != 1 || c.y_sampling != 1) text += ", subsampled " + size_text(c.x_sampling, c.y_sampling);
    if (parts) text += ", part " + std::to_string(c.part);
    text += ")";
  }
  if (channels.size() > shown) text += " and " + std::to_string(channels.size() - shown) + " more";
  return text;
}

std::string how_to_choose(const std::vector<ChannelInfo>& channels) {
  const bool parts = std::any_of(channels.begin(), channels.end(), [](const ChannelInfo& c) { return c.part != 0; });
  return std::string("; choose one with --channel NAME") + (parts ? ", --layer NAME or --part N" : " or --layer NAME");
}

[[noreturn]] void refuse(const std::string& path, const std::string& why, const std::vector<ChannelInfo>& channels) {
  throw UsageError(path + ": " + why + "; " + listed(channels) +
                   (channels.empty() ? "; export the image again" : how_to_choose(channels)));
}

// Y or R,G,B or the only channel among `group` (all of one part and layer); empty when there is no obvious choice.
Indices obvious(const std::vector<ChannelInfo>& channels, const Indices& group) {
  const auto find = [&](const std::string& base) {
    Indices found;
    for (std::size_t i : group)
      if (upper(base_of(channels[i].name)) == base) found.push_back(i);
    return found;
  };
  if (const Indices visible = without_alpha(channels, group); visible.size() == 1) return visible;
  if (const Indices y = find("Y"); y.size() == 1 && find("X").empty()) return y;  // X, Y, Z are coordinates or CIE
  const Indices r = find("R"), g = find("G"), b = find("B");
  if (r.size() == 1 && g.size() == 1 && b.size() == 1) return {r[0], g[0], b[0]};
  return {};
}

Indices by_default(const std::string& path, const std::vector<ChannelInfo>& channels, const Indices& allowed) {
  std::map<std::pair<int, std::string>, Indices> groups;
  for (std::size_t i : allowed) groups[{channels[i].part, channels[i].layer}].push_back(i);
  if (const Indices visible = without_alpha(channels, allowed); visible.size() == 1) return visible;
  if (groups.size() == 1) {
    if (const Indices only = obvious(channels, groups.begin()->second); !only.empty()) return only;
    refuse(path, "no channel is the obvious one", channels);
  }
  std::vector<Indices> plain;
  for (const auto& [key, group] : groups) {
    if (!key.second.empty()) continue;
    const Indices found = obvious(channels, group);
    if (!found.empty()) plain.push_back(found);
  }
  // A lone "Z" or mask in a file with layers of colour is not what a user means by the image.
  std::erase_if(plain, [&](const Indices& p) { return p.size() == 1 && upper(base_of(channels[p[0]].name)) != "Y"; });
  if (plain.size() == 1) return plain[0];
  refuse(path, plain.empty() ? "no channel is the obvious one" : "several parts hold an image", channels);
}

Indices by_layer(const std::string& path, const std::vector<ChannelInfo>& channels, const Indices& allowed,
                 const std::string& layer) {
  Indices group;
  for (std::size_t i : allowed)
    if (channels[i].layer == layer) group.push_back(i);
  if (group.empty())  // many writers name the part after the layer and the channels just R, G, B
    for (std::size_t i : allowed)
      if (channels[i].part_name == layer && channels[i].layer.empty()) group.push_back(i);
  const std::string named = layer.empty() ? "channels without a layer" : "layer '" + printable(layer) + "'";
  if (group.empty()) refuse(path, "there is no " + named, channels);
  for (std::size_t i : group)
    if (channels[i].part != channels[group[0]].part) refuse(path, named + " occurs in several parts", channels);
  const Indices found = obvious(channels, group);
  if (found.empty()) refuse(path, named + " is neither a single channel nor Y nor R,G,B", channels);
  return found;
}

Indices by_name(const std::string& path, const std::vector<ChannelInfo>& channels, const Indices& allowed,
                const ReadOptions& options) {
  Indices found;
  const std::string& wanted = *options.channel;
  for (std::size_t i : allowed) {
    const ChannelInfo& c = channels[i];
    const bool in_layer =
        !options.layer || c.layer == *options.layer || (c.layer.empty() && c.part_name == *options.layer);
    if (in_layer && (c.name == wanted || (options.layer && base_of(c.name) == wanted))) found.push_back(i);
  }
  const std::string named =
      "channel '" + printable(wanted) + "'" + (options.layer ? " in layer '" + printable(*options.layer) + "'" : "");
  if (found.empty()) refuse(path, "there is no " + named, channels);
  if (found.size() > 1) refuse(path, named + " occurs in several parts", channels);
  return found;
}

}  // namespace

std::string layer_of(const std::string& channel_name) {
  const auto dot = channel_name.rfind('.');
  return dot == std::string::npos ? "" : channel_name.substr(0, dot);
}

std::string base_of(const std::string& channel_name) {
  const auto dot = channel_name.rfind('.');
  return dot == std::string::npos ? channel_name : channel_name.substr(dot + 1);
}

ChannelChoice choose_channels(const std::string& path, const std::vector<ChannelInfo>& channels,
                              const ReadOptions& options) {
  Indices allowed;
  for (std::size_t i = 0; i < channels.size(); ++i)
    if (!options.part || channels[i].part == *options.part) allowed.push_back(i);
  if (allowed.empty())
    refuse(path, options.part ? "part " + std::to_string(*options.part) + " has no channels" : "no usable channel",
           channels);

  // Deep channels count only when they are asked for, so that another part with one sample a pixel is found.
  Indices flat = allowed;
  std::erase_if(flat, [&](std::size_t i) { return channels[i].type.starts_with("deep"); });
  if (flat.empty())
    throw UsageError(
        path + ": deep data (several samples a pixel, part " + std::to_string(channels[allowed[0]].part) +
        (channels[allowed[0]].part_name.empty() ? "" : " '" + printable(channels[allowed[0]].part_name) + "'") +
        ") is not read; flatten the image in the renderer or compositor first; " + listed(channels));

  ChannelChoice choice;
  bool spectral = false;
  if (options.channel)
    choice.indices = by_name(path, channels, flat, options);
  else if (options.layer)
    choice.indices = by_layer(path, channels, flat, *options.layer);
  else if (choice.indices = spectral_choice(path, channels, flat); choice.indices.empty())
    choice.indices = by_default(path, channels, flat);
  else
    spectral = true;

  const bool triple = choice.indices.size() == 3 && !spectral;
  for (std::size_t i : choice.indices) {
    const ChannelInfo& c = channels[i];
    if (c.x_sampling != 1 || c.y_sampling != 1)
      throw UsageError(
          path + ": channel " + printable(c.name) + " is subsampled " + size_text(c.x_sampling, c.y_sampling) +
          "; choose a channel at full resolution (Y of a luminance-chroma file): --channel NAME; " + listed(channels));
    choice.names.push_back(triple ? upper(base_of(c.name)) : c.name);
  }
  return choice;
}

}  // namespace mtf::io
