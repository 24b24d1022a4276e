// SPDX-License-Identifier: Apache-2.0
#include "mtf/io/csv/spectrum_csv.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <optional>

#include "mtf/error.h"
#include "mtf/io/csv/csv_numbers.h"
#include "mtf/io/csv/spectral_units.h"
#include "mtf/units.h"
#include "mtf/words.h"

namespace mtf::io {
namespace {

using Cells = std::vector<std::string_view>;

const std::string kCurveRemedy =
    "write the first line like this: wavelength_um,quantum_efficiency (or wavelength_nm, wavenumber_cm-1)";
const std::string kPathRemedy =
    "write the first line like this: range_m,wavelength_um,transmission,radiance_w_m2_sr_um";

std::string listed(const Cells& cells) {
  return printable(joined(cells, [](std::string_view cell) { return printable(cell, 40); }));
}

/// The column of wavelength, wavenumber or frequency.
std::size_t place_column(const Cells& cells, const std::vector<SpectralColumn>& columns, const std::string& where,
                         const std::string& remedy) {
  std::optional<std::size_t> found;
  for (std::size_t i = 0; i < columns.size(); ++i) {
    if (!columns[i].is_place) continue;
    if (found) throw UsageError(where + "more than one column of wavelengths or wavenumbers; leave one");
    found = i;
  }
  if (!found)
    throw UsageError(where + "no column is called wavelength or wavenumber (found: " + listed(cells) + "); " + remedy);
  if (!columns[*found].place)
    throw UsageError(where + "\"" + printable(cells[*found], 40) + "\" has no unit, or one that is not known; " +
                     remedy);
  return *found;
}

std::size_t value_column(const Cells& cells, const std::vector<SpectralColumn>& columns, const std::string& name,
                         const std::string& where, const std::string& remedy) {
  std::vector<std::size_t> found;
  for (std::size_t i = 0; i < columns.size(); ++i)
    if (!columns[i].is_place && columns[i].name == name) found.push_back(i);
  if (found.size() != 1)
    throw UsageError(where + (found.empty() ? "no column" : "more than one column") + " is called " + name +
                     " (found: " + listed(cells) + "); " + remedy);
  return found.front();
}

double checked_um(const SpectralColumn& column, double value, const std::string& where) {
  const double wavelength_um = column.place->to_um(value);
  if (!(value > 0.0) || !(wavelength_um > 0.0) || !std::isfinite(wavelength_um))
    throw UsageError(where + column.name + " " + format_double(value) + "; it has to be above 0");
  return wavelength_um;
}

void require_not_negative(double value, const std::string& name, const std::string& where) {
  if (value < 0.0 || !std::isfinite(value))
    throw UsageError(where + name + " " + format_double(value) + "; it has to be 0 or above");
}

std::vector<SpectralColumn> describe(const Cells& cells) {
  std::vector<SpectralColumn> columns;
  for (const std::string_view cell : cells) columns.push_back(spectral_column(cell));
  return columns;
}

}  // namespace

SpectrumColumns parse_spectrum_csv(std::string_view text, const std::string& source,
                                   const std::vector<std::string>& names) {
  std::vector<SpectralColumn> chosen;
  const CsvNumbers numbers =
      read_csv_numbers(text, source, kCurveRemedy, [&](const Cells& cells, const std::string& where) {
        const std::vector<SpectralColumn> columns = describe(cells);
        std::vector<std::size_t> indices{place_column(cells, columns, where, kCurveRemedy)};
        if (names.size() == 1 && cells.size() == 2)
          indices.push_back(1 - indices[0]);
        else
          for (const std::string& name : names)
            indices.push_back(value_column(cells, columns, name, where, kCurveRemedy));
        for (const std::size_t i : indices) chosen.push_back(columns[i]);
        return indices;
      });
  const auto where = [&](std::size_t row) { return source + ":" + std::to_string(numbers.line[row]) + ": "; };

  std::vector<double> wavelength_um;
  for (std::size_t row = 0; row < numbers.line.size(); ++row)
    wavelength_um.push_back(checked_um(chosen[0], numbers.column[0][row], where(row)));
  std::vector<std::size_t> order(wavelength_um.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::stable_sort(order, [&](std::size_t a, std::size_t b) { return wavelength_um[a] < wavelength_um[b]; });
  SpectrumColumns result{source, {}, std::vector<std::vector<double>>(names.size())};
  for (const std::size_t row : order) {
    if (!result.wavelength_um.empty() && wavelength_um[row] == result.wavelength_um.back())
      throw UsageError(where(row) + chosen[0].name + " " + format_double(numbers.column[0][row]) +
                       " is there twice; leave one");
    result.wavelength_um.push_back(wavelength_um[row]);
    for (std::size_t i = 0; i < names.size(); ++i) {
      const double value = numbers.column[i + 1][row];
      require_not_negative(value, chosen[i + 1].name, where(row));
      result.columns[i].push_back(in_our_units(chosen[i + 1], value, wavelength_um[row]));
    }
  }
  return result;
}

PathColumns parse_path_csv(std::string_view text, const std::string& source) {
  std::vector<SpectralColumn> chosen;
  double m_per_range = 1.0;
  const CsvNumbers numbers =
      read_csv_numbers(text, source, kPathRemedy, [&](const Cells& cells, const std::string& where) {
        const std::vector<SpectralColumn> columns = describe(cells);
        std::vector<std::size_t> indices;
        for (std::size_t i = 0; i < columns.size(); ++i)
          if (columns[i].name == "range_m" || columns[i].name == "range_km") indices.push_back(i);
        if (indices.size() != 1)
          throw UsageError(where + (indices.empty() ? "no" : "more than one") +
                           " column is called range_m or range_km (found: " + listed(cells) + "); " + kPathRemedy);
        m_per_range = columns[indices[0]].name == "range_km" ? 1e3 : 1.0;
        indices.push_back(place_column(cells, columns, where, kPathRemedy));
        for (const char* name : {"transmission", "radiance"})
          indices.push_back(value_column(cells, columns, name, where, kPathRemedy));
        if (!columns[indices[3]].density)
          throw UsageError(where + "\"" + printable(cells[indices[3]], 40) +
                           "\" has no unit, or one that is not known; " + kPathRemedy);
        for (const std::size_t i : indices) chosen.push_back(columns[i]);
        return indices;
      });

  struct Row {
    double transmission, radiance;
    std::size_t line;
  };
  std::map<double, std::map<double, Row>> table;  // by range, by wavelength
  for (std::size_t row = 0; row < numbers.line.size(); ++row) {
    const std::string where = source + ":" + std::to_string(numbers.line[row]) + ": ";
    const double range_m = numbers.column[0][row] * m_per_range;
    if (!(range_m > 0.0) || !std::isfinite(range_m))
      throw UsageError(where + "a range of " + format_double(range_m) +
                       " m; ranges are above 0 (a path of length 0 is clear, leave it out)");
    const double wavelength_um = checked_um(chosen[1], numbers.column[1][row], where);
    const double transmission = in_our_units(chosen[2], numbers.column[2][row], wavelength_um);
    const double radiance = in_our_units(chosen[3], numbers.column[3][row], wavelength_um);
    if (!(transmission >= 0.0 && transmission <= 1.0))
      throw UsageError(where + "a transmission of " + format_double(transmission) +
                       "; it has to be from 0 to 1 (call the column \"transmission (%)\" if it is in percent)");
    require_not_negative(radiance, "radiance", where);
    if (!table[range_m].emplace(wavelength_um, Row{transmission, radiance, numbers.line[row]}).second)
      throw UsageError(where + "this wavelength is there twice for a range of " + format_double(range_m) +
                       " m; leave one");
  }

  PathColumns result{.source = source};
  for (const auto& [wavelength_um, row] : table.begin()->second) result.wavelength_um.push_back(wavelength_um);
  for (const auto& [range_m, curve] : table) {
    const bool same =
        curve.size() == result.wavelength_um.size() &&
        std::equal(curve.begin(), curve.end(), result.wavelength_um.begin(),
                   [](const auto& sample, double wavelength_um) { return sample.first == wavelength_um; });
    if (!same)
      throw UsageError(source + ":" + std::to_string(curve.begin()->second.line) + ": the range of " +
                       format_double(range_m) + " m has other wavelengths (" + std::to_string(curve.size()) +
                       ") than that of " + format_double(result.range_m.empty() ? range_m : result.range_m.front()) +
                       " m (" + std::to_string(result.wavelength_um.size()) + "); give all ranges the same");
    result.range_m.push_back(range_m);
    std::vector<double>&transmission = result.transmission.emplace_back(), &radiance = result.radiance.emplace_back();
    for (const auto& [wavelength_um, row] : curve) {
      transmission.push_back(row.transmission);
      radiance.push_back(row.radiance);
    }
  }
  return result;
}

SpectrumColumns read_spectrum_csv(const std::string& path, const std::vector<std::string>& names) {
  return parse_spectrum_csv(read_table_text(path), path, names);
}

PathColumns read_path_csv(const std::string& path) { return parse_path_csv(read_table_text(path), path); }

}  // namespace mtf::io
