// SPDX-License-Identifier: Apache-2.0
#include "apps/scene/heat/read_facet_table.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>

#include "apps/scene/heat/npy_rows.h"
#include "apps/text/message_words.h"
#include "mtf/error.h"
#include "mtf/io/csv/csv_cells.h"
#include "mtf/io/csv/csv_numbers.h"
#include "radiometry/weather/instant.h"

namespace apps::scene {
namespace {

constexpr std::size_t kMostBytes = std::size_t{4} << 30;
constexpr double kHottest_k = 3000.0;

[[noreturn]] void fail(const std::string& source, const std::string& text) {
  throw mtf::UsageError(one_line(source) + ": " + text);
}

bool is_temperature(float kelvin) { return kelvin > 0.0F && static_cast<double>(kelvin) <= kHottest_k; }

FacetTable read_npy(const std::string& path, std::size_t facets) {
  NpyRows rows(path);
  if (rows.columns() != facets)
    fail(path, "has " + std::to_string(rows.columns()) + " facets, the scene " + std::to_string(facets));
  if (rows.rows() > kMostBytes / sizeof(float) / facets)
    fail(path, std::to_string(rows.rows()) + " rows of " + std::to_string(facets) + " facets are more than " +
                   std::to_string(kMostBytes >> 30) + " GiB; give fewer rows");
  FacetTable table{path, {}, facets, {}};
  for (std::uint64_t i = 0; i < rows.rows(); ++i) {
    const std::vector<float> row = rows.row(i);
    table.kelvin.insert(table.kelvin.end(), row.begin(), row.end());
  }
  if (rows.rows() > 1)
    table.time_s = read_output_times((std::filesystem::path(path).parent_path() / "times.csv").string(), rows.rows());
  return table;
}

FacetTable read_csv(const std::string& path, std::size_t facets) {
  const std::string remedy = "the columns are facet,temperature_K";
  const mtf::io::CsvNumbers numbers = mtf::io::read_csv_numbers(
      mtf::io::read_table_text(path), path, remedy, [&](const auto& cells, const std::string& where) {
        std::vector<std::size_t> columns;
        for (const std::string_view name : {"facet", "temperature_K"}) {
          const auto found = std::find(cells.begin(), cells.end(), name);
          if (found == cells.end()) throw mtf::UsageError(where + "no column '" + std::string(name) + "'; " + remedy);
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

std::vector<double> read_output_times(const std::string& file, std::uint64_t rows) {
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

FacetTable read_facet_table(const std::string& path, std::size_t facets) {
  FacetTable table = path.ends_with(".npy") ? read_npy(path, facets) : read_csv(path, facets);
  for (std::size_t i = 0; i < table.kelvin.size(); ++i)
    if (const auto kelvin = static_cast<double>(table.kelvin[i]);
        !std::isnan(kelvin) && !is_temperature(table.kelvin[i]))
      fail(path, "facet " + std::to_string(i % facets) + " has " + significant(kelvin, 4) + " K, which no surface has");
  return table;
}

}  // namespace apps::scene
