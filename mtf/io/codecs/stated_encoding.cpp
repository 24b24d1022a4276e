// SPDX-License-Identifier: Apache-2.0
#include "mtf/io/codecs/stated_encoding.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "mtf/io/csv/csv_cells.h"

namespace mtf::io {
namespace {

std::string gamma_word(double exponent) { return exponent == 1.0 ? "linear" : "gamma:" + number_text(exponent); }

/// The exponent with the fewest decimals for which `fits` holds.
template <class Fits>
std::optional<double> shortest(double exponent, const Fits& fits) {
  for (const double scale : {1.0, 10.0, 100.0, 1e3, 1e4, 1e5, 1e6})
    if (const double rounded = std::round(exponent * scale) / scale; fits(rounded)) return rounded;
  return std::nullopt;
}

/// Names under which the profile of IEC 61966-2-1 is found: those of HP and Microsoft, of ICC, GIMP, Little CMS and
/// ArgyllCMS. Others may have the primaries of sRGB and another curve.
bool is_srgb_profile(std::string_view name) {
  constexpr std::array<std::string_view, 8> names{
      "sRGB",     "sRGB IEC61966-2.1", "sRGB IEC61966-2-1",  "sRGB IEC61966-2-1 black scaled",
      "sRGB2014", "sRGB built-in",     "GIMP built-in sRGB", "Artifex sRGB"};
  return std::find(names.begin(), names.end(), name) != names.end();
}

std::string quoted_profile(const std::string& name) {
  return name.empty() ? "ICC profile" : "ICC profile \"" + name + "\"";
}

StatedEncoding by_gamma(std::uint32_t gamma_e5) {
  const double stored = gamma_e5;
  const std::string source = "gAMA chunk (" + number_text(stored / 1e5) + ")";
  if (!(stored >= 1e4 && stored <= 1e6)) return {"", source};
  // Five digits were kept of 1 / exponent: 45455 was 1 / 2.2.
  const auto fits = [&](double exponent) { return exponent > 0.0 && std::round(1e5 / exponent) == stored; };
  return {gamma_word(shortest(1e5 / stored, fits).value_or(1e5 / stored)), source};
}

/// Transfer functions of ITU-T H.273, table 3. Those of television have a part that is meant for dim rooms, or no end
/// of scale: the user has to say what is wanted.
StatedEncoding by_transfer(int transfer) {
  const std::string source = "cICP chunk (transfer function " + std::to_string(transfer) + ")";
  for (const auto& [code, word] : {std::pair{4, "gamma:2.2"}, {5, "gamma:2.8"}, {8, "linear"}, {13, "srgb"}})
    if (transfer == code) return {word, source};
  return {"", source};
}

double srgb_light(double v) { return v <= 0.04045 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4); }

/// The word whose curve a table of 2^n values follows within one count of 65535.
std::string word_of_table(std::span<const std::uint16_t> table) {
  if (table.size() < 4) return "";
  const double last = static_cast<double>(table.size() - 1);
  const auto follows = [&](const auto& light) {
    for (std::size_t i = 0; i < table.size(); ++i)
      if (std::abs(table[i] - 65535.0 * light(static_cast<double>(i) / last)) > 1.0) return false;
    return true;
  };
  if (follows([](double v) { return v; })) return "linear";
  if (follows(srgb_light)) return "srgb";
  const std::size_t middle = table.size() / 2;
  if (table[middle] == 0) return "";
  const double exponent = std::log(table[middle] / 65535.0) / std::log(static_cast<double>(middle) / last);
  if (!(exponent >= 0.1 && exponent <= 10.0)) return "";
  const auto found = shortest(exponent, [&](double g) { return follows([g](double v) { return std::pow(v, g); }); });
  return found ? gamma_word(*found) : "";
}

std::uint32_t big_endian(std::span<const unsigned char> bytes, std::size_t at) {
  return std::uint32_t{bytes[at]} << 24U | std::uint32_t{bytes[at + 1]} << 16U | std::uint32_t{bytes[at + 2]} << 8U |
         bytes[at + 3];
}

bool has_word(std::span<const unsigned char> bytes, std::size_t at, std::string_view word) {
  return std::equal(word.begin(), word.end(), bytes.begin() + static_cast<std::ptrdiff_t>(at));
}

}  // namespace

StatedEncoding stated_by_png(const PngColour& colour) {
  if (colour.transfer) return by_transfer(*colour.transfer);
  if (colour.profile && is_srgb_profile(*colour.profile)) return {"srgb", quoted_profile(*colour.profile)};
  StatedEncoding stated;
  if (colour.srgb)
    stated = {"srgb", "sRGB chunk"};
  else if (colour.gamma_e5)
    stated = by_gamma(*colour.gamma_e5);
  if (colour.profile) stated.source += (stated.source.empty() ? "" : " beside ") + quoted_profile(*colour.profile);
  return stated;
}

std::string icc_name(std::span<const unsigned char> profile) {
  constexpr std::size_t header = 128, row = 12;
  if (profile.size() < header + 4) return "";
  const std::size_t rows = std::min<std::size_t>(big_endian(profile, header), (profile.size() - header - 4) / row);
  for (std::size_t i = 0; i < rows; ++i) {
    const std::size_t at = header + 4 + i * row;
    if (!has_word(profile, at, "desc")) continue;
    const std::size_t offset = big_endian(profile, at + 4), size = big_endian(profile, at + 8);
    if (offset > profile.size() || size > profile.size() - offset || size < 12) return "";
    const auto tag = profile.subspan(offset, size);
    std::string name;
    const auto add = [&](unsigned char c) {
      if (c >= 0x20 && c < 0x7f) name += static_cast<char>(c);
    };
    if (has_word(tag, 0, "desc")) {  // version 2: count, ASCII
      const std::size_t count = std::min<std::size_t>(big_endian(tag, 8), size - 12);
      for (const unsigned char c : tag.subspan(12, count)) add(c);
    } else if (has_word(tag, 0, "mluc") && size >= 28) {  // version 4: the first language, UTF-16
      const std::size_t length = big_endian(tag, 20), start = big_endian(tag, 24);
      if (start > size || length > size - start) return "";
      for (std::size_t k = start; k + 1 < start + length; k += 2)
        if (tag[k] == 0) add(tag[k + 1]);
    }
    return name;
  }
  return "";
}

StatedEncoding stated_by_tiff(std::span<const std::span<const std::uint16_t>> tables,
                              std::span<const unsigned char> profile) {
  if (!profile.empty()) {
    const std::string name = icc_name(profile);
    if (is_srgb_profile(name)) return {"srgb", quoted_profile(name)};
    if (tables.empty()) return {"", quoted_profile(name)};
  }
  if (tables.empty()) return {};
  const auto same = [&](std::span<const std::uint16_t> table) {
    return std::equal(table.begin(), table.end(), tables.front().begin(), tables.front().end());
  };
  StatedEncoding stated{"", "TransferFunction tag"};
  if (std::all_of(tables.begin(), tables.end(), same)) stated.word = word_of_table(tables.front());
  if (!profile.empty()) stated.source += " beside " + quoted_profile(icc_name(profile));
  return stated;
}

}  // namespace mtf::io
