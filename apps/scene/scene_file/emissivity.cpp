// SPDX-License-Identifier: Apache-2.0

// Emissivities: numbers, bands, spectra, and the Planck mean of a spectrum e,
//   integral of e(l) B(l, T) dl / (sigma T^4 / pi),
// with e held beyond its first and last sample. Between two samples e is a straight line; the blackbody's radiance in
// short stretches is exact (radiometry/light/blackbody.h), e is taken in the middle of each.

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "apps/scene/scene_file/scene_reader.h"
#include "mtf/error.h"
#include "mtf/io/csv/csv_cells.h"
#include "mtf/io/csv/csv_numbers.h"
#include "mtf/io/csv/spectrum_csv.h"
#include "mtf/words.h"
#include "radiometry/light/blackbody.h"
#include "radiometry/light/constants.h"

namespace apps::scene {
namespace {

using radiometry::Spectrum;

constexpr double kMeanTemperature_k = 300.0;

/// Bands as a spectrum that jumps: both samples of a jump are as close as doubles can be.
Spectrum spectrum_of_bands(std::string_view text, const std::string& path) {
  const std::string remedy = "write from_um,to_um,emissivity";
  const auto table = mtf::io::read_csv_numbers(text, path, remedy, [&](const auto& cells, const std::string& where) {
    if (cells.size() != 3 || cells[1] != "to_um" || cells[2] != "emissivity")
      throw mtf::UsageError(where + "a table of bands has other columns; " + remedy);
    return std::vector<std::size_t>{0, 1, 2};
  });
  std::vector<double> wavelength_um, value;
  for (std::size_t i = 0; i < table.line.size(); ++i) {
    const double from = table.column[0][i], to = table.column[1][i];
    const auto where = [&] { return path + ":" + std::to_string(table.line[i]) + ": "; };
    if (!(from > 0.0 && to > from))
      throw mtf::UsageError(where() + "the band has to go from above 0 um to a longer wavelength");
    if (i > 0 && from < table.column[1][i - 1])
      throw mtf::UsageError(where() + "the band overlaps the one above it; sort the bands by wavelength");
    wavelength_um.insert(wavelength_um.end(), {from, std::nextafter(to, 0.0)});
    value.insert(value.end(), {table.column[2][i], table.column[2][i]});
  }
  return radiometry::make_spectrum(path, std::move(wavelength_um), std::move(value), 1.0);
}

Spectrum read_table(const std::string& path) {
  const std::string text = mtf::io::read_table_text(path);
  std::string_view rest = mtf::io::without_mark(text);
  std::string_view header;
  while (!rest.empty() && mtf::io::is_comment(header)) header = mtf::io::take_text_line(rest);
  if (mtf::io::trimmed_cell(header).starts_with("from_")) return spectrum_of_bands(text, path);
  auto columns = mtf::io::parse_spectrum_csv(text, path, {"emissivity"});
  return radiometry::make_spectrum(path, std::move(columns.wavelength_um), std::move(columns.columns.front()), 1.0);
}

}  // namespace

double planck_mean(const Spectrum& emissivity, double temperature_k) {
  constexpr double kWidestPart = 0.01;  // of the wavelength
  constexpr int kMostParts = 400;
  const auto& l = emissivity.wavelength_um;
  const auto& e = emissivity.value;
  const auto radiance = [&](double lo, double hi) {
    return radiometry::band_radiance(radiometry::Flux::watts, lo, hi, temperature_k);
  };
  double sum =
      e.front() * radiance(0.0, l.front()) + e.back() * radiance(l.back(), std::numeric_limits<double>::infinity());
  for (std::size_t i = 0; i + 1 < l.size(); ++i) {
    const double width = l[i + 1] - l[i];
    const int parts =
        e[i] == e[i + 1] ? 1 : std::clamp(static_cast<int>(std::ceil(width / (kWidestPart * l[i]))), 1, kMostParts);
    for (int k = 0; k < parts; ++k)
      sum += std::lerp(e[i], e[i + 1], (k + 0.5) / parts) *
             radiance(l[i] + width * k / parts, l[i] + width * (k + 1) / parts);
  }
  return sum * std::numbers::pi / (radiometry::kStefanBoltzmann_w_m2_k4 * std::pow(temperature_k, 4));
}

void read_value(SceneReader& s, const Section& section, const FieldInfo& row, std::optional<Emissivity>& value) {
  const cfg::Node* node = section.find(row.name);
  if (node == nullptr) return;
  const auto fail = [&](const std::string& text) { section.error(row.name, mtf::printable(text, 600)); };
  if (node->kind != cfg::Node::Kind::string) {
    if (const auto number = read_si(section, row)) value = {.value = *number, .spectrum = {}, .along_normal = *number};
    return;
  }
  if (mtf::io::cell_number(node->text))
    return fail(cfg::shown(*node) + " is a string; write the number without quotes");
  std::string path;
  read_value(s, section, of_type(FieldType::file, row), path);
  if (path.empty()) return;
  try {
    Spectrum spectrum = read_table(path);
    const double mean = planck_mean(spectrum, kMeanTemperature_k);
    value = {.value = std::min(mean, 1.0), .spectrum = std::move(spectrum), .along_normal = mean};
  } catch (const mtf::Error& error) {
    fail(error.what());
  }
}

}  // namespace apps::scene
