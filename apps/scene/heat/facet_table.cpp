// SPDX-License-Identifier: Apache-2.0
#include "apps/scene/heat/facet_table.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <limits>

#include "apps/text/words.h"
#include "mtf/error.h"
#include "mtf/io/csv/csv_cells.h"
#include "mtf/io/csv/csv_numbers.h"
#include "radiometry/heat/weather/instant.h"

namespace apps::scene {
namespace {

constexpr std::size_t kMostBytes = std::size_t{4} << 30;
constexpr double kHottest_k = 3000.0;

[[noreturn]] void fail(const std::string& source, const std::string& text) {
  throw mtf::UsageError(one_line(source) + ": " + text);
}

/// What stands behind `'key': ` in the header of an NPY file.
std::string_view entry(std::string_view header, const std::string& key) {
  const std::size_t at = header.find("'" + key + "'");
  if (at == std::string_view::npos) return {};
  const std::size_t colon = header.find(':', at);
  return colon == std::string_view::npos ? std::string_view() : header.substr(colon + 1);
}

struct NpyShape {
  std::size_t rows = 1, columns = 0, item = 4, begin = 0;
};

NpyShape shape_of(std::string_view bytes, const std::string& source) {
  constexpr std::string_view magic("\x93NUMPY", 6);
  if (bytes.size() < 12 || !bytes.starts_with(magic)) fail(source, "is no NPY file");
  const auto byte = [&](std::size_t i) { return static_cast<std::size_t>(static_cast<unsigned char>(bytes[i])); };
  const bool first = byte(6) == 1;
  NpyShape shape;
  const std::size_t length =
      first ? byte(8) + 256 * byte(9) : byte(8) + 256 * (byte(9) + 256 * (byte(10) + 256 * byte(11)));
  shape.begin = (first ? 10 : 12) + length;
  if (shape.begin > bytes.size()) fail(source, "the header of the NPY file is cut off");
  const std::string_view header = bytes.substr(first ? 10 : 12, length);
  const std::string_view descr = entry(header, "descr"), order = entry(header, "fortran_order");
  shape.item = descr.find("'<f4'") < 4 ? 4 : descr.find("'<f8'") < 4 ? 8 : 0;
  if (shape.item == 0 || order.find("False") > 4)
    fail(source, "float32 or float64 in C order belongs here, as numpy.save writes it");
  std::string_view text = entry(header, "shape");
  text = text.substr(std::min(text.find('('), text.size()));
  text = text.substr(0, text.find(')'));
  std::vector<std::size_t> sizes;
  while (sizes.size() < 3) {
    text.remove_prefix(std::min(text.find_first_of("0123456789"), text.size()));
    if (text.empty()) break;
    std::size_t value = 0;
    const auto end = std::from_chars(text.data(), text.data() + text.size(), value).ptr;
    text.remove_prefix(static_cast<std::size_t>(end - text.data()));
    sizes.push_back(value);
  }
  if (sizes.empty() || sizes.size() > 2) fail(source, "a table of facets, or of times x facets, belongs here");
  shape.columns = sizes.back();
  if (sizes.size() == 2) shape.rows = sizes.front();
  return shape;
}

/// The instants of times.csv.
std::vector<double> times_of(const std::string& path, std::size_t rows) {
  const std::string file = (std::filesystem::path(path).parent_path() / "times.csv").string();
  const std::string text = mtf::io::read_table_text(file);
  std::string_view rest = mtf::io::without_mark(text);
  std::vector<double> times;
  std::size_t column = 0;
  bool header = true;
  while (!rest.empty()) {
    const std::string_view row = mtf::io::take_text_line(rest);
    if (row.empty() || mtf::io::is_comment(row)) continue;
    const auto cells = mtf::io::split_cells(row, mtf::io::separator_of(row));
    if (header) {
      const auto found = std::find(cells.begin(), cells.end(), "time");
      if (found == cells.end()) fail(file, "has no column 'time'");
      column = static_cast<std::size_t>(found - cells.begin());
      header = false;
      continue;
    }
    radiometry::heat::InstantError error;
    const auto instant = column < cells.size() ? radiometry::heat::parse_instant(cells[column], error) : std::nullopt;
    if (!instant) fail(file, "no instant in line " + std::to_string(times.size() + 2));
    if (!times.empty() && !(*instant > times.back())) fail(file, "the times do not rise");
    times.push_back(*instant);
  }
  if (times.size() != rows)
    fail(file, "has " + std::to_string(times.size()) + " times, the table beside it " + std::to_string(rows) + " rows");
  return times;
}

bool is_temperature(float kelvin) { return kelvin > 0.0F && static_cast<double>(kelvin) <= kHottest_k; }

FacetTable read_npy(const std::string& path, std::size_t facets) {
  const std::string bytes = mtf::io::read_table_text(path, kMostBytes);
  const NpyShape shape = shape_of(bytes, path);
  if (shape.columns != facets)
    fail(path, "has " + std::to_string(shape.columns) + " facets, the scene " + std::to_string(facets));
  const std::size_t count = shape.rows * shape.columns;
  if (shape.rows == 0 || (bytes.size() - shape.begin) / shape.item < count) fail(path, "the NPY file is cut off");
  FacetTable table{path, {}, facets, std::vector<float>(count)};
  for (std::size_t i = 0; i < count; ++i) {
    const char* at = bytes.data() + shape.begin + i * shape.item;
    double wide = 0.0;
    if (shape.item == 4)
      std::memcpy(&table.kelvin[i], at, 4);
    else
      std::memcpy(&wide, at, 8), table.kelvin[i] = static_cast<float>(wide);
  }
  if (shape.rows > 1) table.time_s = times_of(path, shape.rows);
  return table;
}

FacetTable read_csv(const std::string& path, std::size_t facets) {
  const std::string remedy = "; the columns are facet,temperature_K";
  const mtf::io::CsvNumbers numbers = mtf::io::read_csv_numbers(
      mtf::io::read_table_text(path), path, remedy, [&](const auto& cells, const std::string& where) {
        std::vector<std::size_t> columns;
        for (const std::string_view name : {"facet", "temperature_K"}) {
          const auto found = std::find(cells.begin(), cells.end(), name);
          if (found == cells.end()) throw mtf::UsageError(where + "no column '" + std::string(name) + "'" + remedy);
          columns.push_back(static_cast<std::size_t>(found - cells.begin()));
        }
        return columns;
      });
  FacetTable table{path, {}, facets, std::vector<float>(facets, std::numeric_limits<float>::quiet_NaN())};
  for (std::size_t i = 0; i < numbers.line.size(); ++i) {
    const double facet = numbers.column[0][i];
    const std::string where = ":" + std::to_string(numbers.line[i]) + ": error: ";
    if (!(facet >= 0.0 && facet < static_cast<double>(facets)) || facet != std::floor(facet))
      throw mtf::UsageError(one_line(path) + where + "the scene has no such facet; it has " + std::to_string(facets));
    float& kelvin = table.kelvin[static_cast<std::size_t>(facet)];
    if (!std::isnan(kelvin)) throw mtf::UsageError(one_line(path) + where + "the facet stands twice");
    kelvin = static_cast<float>(numbers.column[1][i]);
    if (!is_temperature(kelvin))
      throw mtf::UsageError(one_line(path) + where + significant(numbers.column[1][i], 4) +
                            " K, which no surface has; it has to be above 0 and no more than " +
                            significant(kHottest_k, 4) + " K");
  }
  return table;
}

}  // namespace

double FacetTable::at(std::uint32_t facet, double utc_s) const {
  if (time_s.empty()) return static_cast<double>(kelvin[facet]);
  const auto above = std::upper_bound(time_s.begin(), time_s.end(), utc_s);
  if (above == time_s.begin()) return static_cast<double>(kelvin[facet]);
  const auto k = static_cast<std::size_t>(above - time_s.begin()) - 1;
  if (above == time_s.end()) return static_cast<double>(kelvin[k * facets + facet]);
  const double share = (utc_s - time_s[k]) / (time_s[k + 1] - time_s[k]);
  return std::lerp(static_cast<double>(kelvin[k * facets + facet]),
                   static_cast<double>(kelvin[(k + 1) * facets + facet]), share);
}

double FacetTable::mean(std::uint32_t facet) const {
  double sum = 0.0;
  for (std::size_t i = facet; i < kelvin.size(); i += facets) sum += static_cast<double>(kelvin[i]);
  return sum * static_cast<double>(facets) / static_cast<double>(kelvin.size());
}

FacetTable read_facet_table(const std::string& path, std::size_t facets) {
  FacetTable table = path.ends_with(".npy") ? read_npy(path, facets) : read_csv(path, facets);
  for (std::size_t i = 0; i < table.kelvin.size(); ++i)
    if (const auto kelvin = static_cast<double>(table.kelvin[i]);
        !std::isnan(kelvin) && !is_temperature(table.kelvin[i]))
      fail(path, "facet " + std::to_string(i % facets) + " has " + significant(kelvin, 4) + " K, which no surface has");
  return table;
}

}  // namespace apps::scene
