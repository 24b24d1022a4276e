// SPDX-License-Identifier: Apache-2.0
#include "mtf/io/csv/spectral_units.h"

#include <algorithm>
#include <array>
#include <cctype>

namespace mtf::io {
namespace {

constexpr double kLightSpeed_um_s = 299792458e6;

struct NamedUnit {
  std::string_view name;
  SpectralUnit unit;
};
using enum SpectralUnit::Kind;
constexpr std::array kUnits{NamedUnit{"nm", {wavelength, 1e-3}},       NamedUnit{"um", {wavelength, 1.0}},
                            NamedUnit{"micron", {wavelength, 1.0}},    NamedUnit{"microns", {wavelength, 1.0}},
                            NamedUnit{"mm", {wavelength, 1e3}},        NamedUnit{"m", {wavelength, 1e6}},
                            NamedUnit{"angstrom", {wavelength, 1e-4}}, NamedUnit{"cm_1", {wavenumber, 1.0}},
                            NamedUnit{"1_cm", {wavenumber, 1.0}},      NamedUnit{"cm1", {wavenumber, 1.0}},
                            NamedUnit{"hz", {frequency, 1.0}},         NamedUnit{"ghz", {frequency, 1e9}},
                            NamedUnit{"thz", {frequency, 1e12}}};

struct DensityUnit {
  std::string_view name;  ///< without separators, powers of 1 and "per"
  double factor;
  bool per_wavenumber;
};
constexpr std::array kDensities{
    DensityUnit{"wm2srum", 1.0, false},   DensityUnit{"wm2srnm", 1e3, false},    DensityUnit{"wm2srm", 1e-6, false},
    DensityUnit{"mwm2srum", 1e-3, false}, DensityUnit{"mwm2srnm", 1.0, false},   DensityUnit{"wcm2srum", 1e4, false},
    DensityUnit{"wcm2srnm", 1e7, false},  DensityUnit{"uwcm2srum", 1e-2, false}, DensityUnit{"uwcm2srnm", 10.0, false},
    DensityUnit{"wm2srcm", 1.0, true},    DensityUnit{"mwm2srcm", 1e-3, true},   DensityUnit{"wcm2srcm", 1e4, true}};

/// "w_m_2_sr_1_um_1" -> "wm2srum"
std::string without_ones(std::string_view plain) {
  std::string joined;
  for (std::size_t at = 0; at <= plain.size();) {
    const std::size_t end = std::min(plain.find('_', at), plain.size());
    const std::string_view word = plain.substr(at, end - at);
    if (word != "1" && word != "per") joined += word;
    at = end + 1;
  }
  return joined;
}

const DensityUnit* find_density(std::string_view plain) {
  const std::string name = without_ones(plain);
  const auto* found = std::ranges::find_if(kDensities, [&](const DensityUnit& unit) { return unit.name == name; });
  return found == kDensities.end() ? nullptr : found;
}

}  // namespace

std::string plain_words(std::string_view cell) {
  std::string name;
  for (std::size_t i = 0; i < cell.size(); ++i) {
    const std::string_view two = cell.substr(i, 2);
    if (two == "\xC2\xB5" || two == "\xCE\xBC") {  // micro sign, Greek mu
      name += 'u';
      ++i;
    } else if (std::isalnum(static_cast<unsigned char>(cell[i]))) {
      name += static_cast<char>(std::tolower(static_cast<unsigned char>(cell[i])));
    } else if (!name.empty() && name.back() != '_') {
      name += '_';
    }
  }
  while (name.ends_with('_')) name.pop_back();
  return name;
}

double SpectralUnit::to_um(double value) const {
  const double scaled = value * factor;
  return kind == wavelength ? scaled : kind == wavenumber ? 1e4 / scaled : kLightSpeed_um_s / scaled;
}

std::optional<SpectralUnit> find_spectral_unit(std::string_view plain) {
  const auto* found = std::ranges::find_if(kUnits, [&](const NamedUnit& unit) { return unit.name == plain; });
  if (found == kUnits.end()) return std::nullopt;
  return found->unit;
}

SpectralColumn spectral_column(std::string_view header_cell) {
  SpectralColumn column;
  column.name = plain_words(header_cell);
  const std::string plain = column.name;
  for (const std::string_view word : {"wavelength", "lambda", "wavenumber", "nu", "frequency", "freq"}) {
    if (plain != word && !plain.starts_with(std::string(word) + "_")) continue;
    column.is_place = true;
    column.name = word;
    if (plain.size() > word.size()) column.place = find_spectral_unit(plain.substr(word.size() + 1));
    return column;
  }
  if (header_cell.find('%') != std::string_view::npos || plain.ends_with("_percent")) {
    if (plain.ends_with("_percent")) column.name.resize(plain.size() - 8);
    column.factor = 0.01;
    return column;
  }
  for (std::size_t at = plain.find('_'); at != std::string::npos; at = plain.find('_', at + 1)) {
    const DensityUnit* unit = find_density(std::string_view(plain).substr(at + 1));
    if (unit == nullptr) continue;
    column.name.resize(at);
    column.factor = unit->factor;
    column.per_wavenumber = unit->per_wavenumber;
    column.density = true;
    break;
  }
  return column;
}

double in_our_units(const SpectralColumn& column, double value, double wavelength_um) {
  const double scaled = value * column.factor;
  if (!column.per_wavenumber) return scaled;
  const double wavenumber_cm = 1e4 / wavelength_um;
  return scaled * (wavenumber_cm * wavenumber_cm / 1e4);
}

}  // namespace mtf::io
