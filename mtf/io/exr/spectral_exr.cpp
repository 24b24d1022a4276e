// SPDX-License-Identifier: Apache-2.0
#include "mtf/io/exr/spectral_exr.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "mtf/error.h"
#include "mtf/io/channel_choice.h"
#include "mtf/io/csv/csv_cells.h"
#include "mtf/units.h"
#include "mtf/words.h"

namespace mtf::io {
namespace {

constexpr double kLightSpeed_m_s = 299792458.0;
constexpr double kShortest_um = 1e-6, kLongest_um = 1e12;

struct Prefix {
  std::string_view name;
  int power;
};
constexpr std::array kPrefixes{Prefix{"Y", 24},  Prefix{"Z", 21}, Prefix{"E", 18}, Prefix{"P", 15}, Prefix{"T", 12},
                               Prefix{"G", 9},   Prefix{"M", 6},  Prefix{"k", 3},  Prefix{"h", 2},  Prefix{"da", 1},
                               Prefix{"d", -1},  Prefix{"c", -2}, Prefix{"m", -3}, Prefix{"u", -6}, Prefix{"n", -9},
                               Prefix{"p", -12}, Prefix{"", 0}};

/// value x 10^power, rounded once.
double times_ten(double value, int power) {
  return power < 0 ? value / std::pow(10.0, -power) : value * std::pow(10.0, power);
}

bool digit(char c) { return c >= '0' && c <= '9'; }

/// "550,000000nm" or "5,4E5GHz" in um.
std::optional<double> wavelength_um(std::string_view text) {
  std::string number;
  std::size_t at = 0;
  const auto digits = [&] {
    while (at < text.size() && digit(text[at])) number += text[at++];
  };
  digits();
  if (at < text.size() && text[at] == ',') {
    number += '.';
    ++at;
    digits();
  }
  if (std::none_of(number.begin(), number.end(), digit)) return std::nullopt;
  if (at < text.size() && (text[at] == 'e' || text[at] == 'E')) {  // E followed by a unit is exa
    std::size_t after = at + 1;
    if (after < text.size() && (text[after] == '+' || text[after] == '-')) ++after;
    if (after < text.size() && digit(text[after])) {
      number += text.substr(at, after - at);
      at = after;
      digits();
    }
  }
  const std::optional<double> value = cell_number(number);
  const std::string_view unit = text.substr(at);
  if (!value) return std::nullopt;
  for (const Prefix& prefix : kPrefixes) {
    if (!unit.starts_with(prefix.name)) continue;
    const std::string_view base = unit.substr(prefix.name.size());
    if (base != "m" && base != "Hz") continue;
    const double um =
        base == "m" ? times_ten(*value, prefix.power + 6) : kLightSpeed_m_s * 1e6 / times_ten(*value, prefix.power);
    if (!(um >= kShortest_um && um <= kLongest_um)) return std::nullopt;
    return um;
  }
  return std::nullopt;
}

/// By its name or, where the file lists wavelengths beside the names, as the radiance there.
std::optional<SpectralChannel> spectral_channel(const ChannelInfo& channel) {
  if (channel.wavelength_um > 0.0) return SpectralChannel{SpectralChannel::Kind::stokes, 0, channel.wavelength_um};
  return parse_spectral_channel(channel.name);
}

std::string attribute(const FileInfo& info, const std::string& name) {
  const auto found = info.attributes.find(name);
  return found == info.attributes.end() ? "" : found->second;
}

}  // namespace

std::optional<SpectralChannel> parse_spectral_channel(std::string_view name) {
  SpectralChannel channel;
  if (name.starts_with("T.")) {
    channel.kind = SpectralChannel::Kind::reflectance;
    name.remove_prefix(2);
    if (const std::size_t dot = name.find('.'); dot != std::string_view::npos) {
      channel.kind = SpectralChannel::Kind::reradiation;
      if (!wavelength_um(name.substr(dot + 1))) return std::nullopt;
      name = name.substr(0, dot);
    }
  } else if (name.size() > 3 && name[0] == 'S' && name[1] >= '0' && name[1] <= '3' && name[2] == '.') {
    channel.stokes = name[1] - '0';
    name.remove_prefix(3);
  } else {
    return std::nullopt;
  }
  const std::optional<double> found = wavelength_um(name);
  if (!found) return std::nullopt;
  channel.wavelength_um = *found;
  return channel;
}

std::vector<std::size_t> spectral_choice(const std::string& path, const std::vector<ChannelInfo>& channels,
                                         const std::vector<std::size_t>& allowed) {
  using Set = std::map<double, std::size_t>;
  std::array<Set, 5> sets;  // S0 to S3, T
  for (const std::size_t i : allowed) {
    const auto channel = spectral_channel(channels[i]);
    if (!channel || channel->kind == SpectralChannel::Kind::reradiation) continue;
    Set& set = sets.at(channel->kind == SpectralChannel::Kind::stokes ? static_cast<std::size_t>(channel->stokes) : 4U);
    const auto [other, added] = set.emplace(channel->wavelength_um, i);
    if (added) continue;
    const ChannelInfo& before = channels[other->second];
    throw UsageError(path + ": " + printable(channels[i].name) + " and " + printable(before.name) +
                     " are the same wavelength" +
                     (before.part != channels[i].part ? " in several parts; choose one with --part N"
                                                      : "; leave one, or choose one with --channel NAME"));
  }
  const Set& radiance = sets[0];
  for (const Set& set : sets) {
    if (set.empty() || &set == &radiance) continue;
    if (radiance.empty())
      throw UsageError(path + ": " + printable(channels[set.begin()->second].name) +
                       " and the like, but no S0 channels: reflectance or polarisation without radiance is no scene; "
                       "render the light, or choose a channel with --channel NAME");
    for (const auto& [wavelength, i] : set)
      if (!radiance.contains(wavelength))
        throw UsageError(path + ": " + printable(channels[i].name) +
                         " has no S0 channel of its wavelength; export the file again");
    for (const auto& [wavelength, i] : radiance)
      if (!set.contains(wavelength))
        throw UsageError(path + ": " + printable(channels[i].name) + " has no counterpart among " +
                         printable(channels[set.begin()->second].name) + " and the like; export the file again");
  }
  std::vector<std::size_t> chosen;
  for (const auto& [wavelength, i] : radiance) {
    if (!chosen.empty() && channels[i].part != channels[chosen.front()].part)
      throw UsageError(path + ": the spectrum is spread over several parts; choose one with --part N");
    chosen.push_back(i);
  }
  return chosen;
}

std::optional<SpectralPlanes> spectral_planes(const std::string& path, const ImageFile& file, bool asked) {
  if (file.names.empty()) return std::nullopt;
  const std::string quantity = attribute(file.info, "mtf:quantity");  // an image of counts keeps its channels' names
  if (!quantity.empty() && quantity != "spectral_radiance") return std::nullopt;
  // Wavelengths of other formats may be those of reflectance or counts.
  if (file.info.format != Format::exr && !asked && quantity.empty()) return std::nullopt;
  SpectralPlanes planes;
  for (const std::string& name : file.names) {
    const auto info = std::ranges::find(file.info.channels, name, &ChannelInfo::name);
    const auto channel = info == file.info.channels.end() ? std::nullopt : spectral_channel(*info);
    if (!channel || channel->kind != SpectralChannel::Kind::stokes || channel->stokes != 0) return std::nullopt;
    planes.wavelength_um.push_back(channel->wavelength_um);
  }
  std::string stated = attribute(file.info, "emissiveUnits");
  if (stated.empty()) stated = attribute(file.info, "mtf:units");
  const auto says = [&](std::string_view unit) { return stated == unit; };
  planes.stated = !stated.empty();
  if (says("W.m^-2.sr^-1"))
    planes.warnings.push_back(path + " states emissiveUnits W.m^-2.sr^-1, which for this layout means per nm");
  if (stated.empty() || says("W.m^-2.sr^-1") || says("W.m^-2.sr^-1.nm^-1"))
    planes.factor = 1e3;
  else if (says("W.m^-2.sr^-1.um^-1"))
    planes.factor = 1.0;
  else if (says("W.m^-2.sr^-1.m^-1"))
    planes.factor = 1e-6;
  else
    throw UsageError(path + ": emissiveUnits \"" + printable(stated, 60) +
                     "\" are not known; W.m^-2.sr^-1.nm^-1, W.m^-2.sr^-1.um^-1 and W.m^-2.sr^-1.m^-1 are");
  std::size_t stokes = 0, reflectance = 0, reradiation = 0;
  for (const ChannelInfo& info : file.info.channels) {
    const auto channel = parse_spectral_channel(info.name);
    if (!channel) continue;
    reflectance += channel->kind == SpectralChannel::Kind::reflectance ? 1U : 0U;
    reradiation += channel->kind == SpectralChannel::Kind::reradiation ? 1U : 0U;
    stokes += channel->kind == SpectralChannel::Kind::stokes && channel->stokes > 0 ? 1U : 0U;
  }
  for (const auto& [count, what] : {std::pair{stokes, "polarisation (S1 to S3)"},
                                    {reflectance, "reflectance (T)"},
                                    {reradiation, "re-radiation (T from one wavelength to another)"}})
    if (count > 0)
      planes.warnings.push_back(path + ": " + what + ", " + std::to_string(count) + " channels, is not used");
  return planes;
}

std::string find_channel(const std::string& path, const FileInfo& info, const std::vector<std::string>& names) {
  for (const std::string& name : names) {
    std::vector<const ChannelInfo*> whole, last;
    for (const ChannelInfo& channel : info.channels) {
      if (lower_case(channel.name) == lower_case(name))
        whole.push_back(&channel);
      else if (lower_case(base_of(channel.name)) == lower_case(name))
        last.push_back(&channel);
    }
    const auto& found = whole.empty() ? last : whole;
    if (found.size() > 1)
      throw UsageError(path + ": " + name + " is there " + std::to_string(found.size()) + " times (" +
                       printable(found[0]->name) + ", " + printable(found[1]->name) + " ...); leave one");
    if (found.size() == 1) return found.front()->name;
  }
  return "";
}

Image read_plane(const std::string& path, const std::vector<std::string>& names) {
  const FileInfo info = read_info(path);
  const std::string channel = find_channel(path, info, names);
  if (channel.empty()) {
    std::string there;
    for (const ChannelInfo& c : info.channels)
      if (there.size() < 400) there += (there.empty() ? "" : ", ") + printable(c.name, 80);
    throw UsageError(path + ": there is no channel " + joined(names, " or ") + "; it has " + there);
  }
  ImageFile file = read_image(path, {.channel = channel});
  return std::move(file.planes.front());
}

}  // namespace mtf::io
