// SPDX-License-Identifier: Apache-2.0
#include "apps/scene/heat/read_temperatures.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <string>
#include <vector>

#include "apps/text/message_words.h"
#include "mtf/error.h"
#include "mtf/io/csv/csv_cells.h"
#include "mtf/io/csv/csv_numbers.h"
#include "mtf/io/npy.h"
#include "radiometry/weather/instant.h"

namespace apps::scene {
namespace {

namespace fs = std::filesystem;
using radiometry::thermal::is_temperature, radiometry::thermal::TemperatureRows;

/// Rows of a table of facets in an NPY file, '<f4' or '<f8': tables of a run hold hundreds of rows of hundreds of
/// thousands of facets, of which a picture needs two.
class NpyRows {
 public:
  /// Throws RuntimeError for a file that cannot be read, UsageError with its name for one that is no table of floats in
  /// C order of one or two dimensions, or is cut off.
  explicit NpyRows(const std::string& path) : file_(path) {
    const auto refuse = [&](const std::string& what) { throw mtf::UsageError(one_line(path) + ": " + what); };
    if (!file_.is_float()) refuse("float32 or float64 in C order belongs here, as numpy.save writes it");
    const std::vector<std::uint64_t>& sizes = file_.shape();
    if (sizes.empty() || sizes.size() > 2) refuse("a table of facets, or of times x facets, belongs here");
    columns_ = sizes.back();
    if (sizes.size() == 2) rows_ = sizes.front();
  }

  std::uint64_t rows() const { return rows_; }
  std::uint64_t columns() const { return columns_; }
  std::vector<float> values(std::uint64_t first, std::uint64_t count) {
    std::vector<float> values(count * columns_);
    file_.read(first * columns_, values);
    return values;
  }

 private:
  mtf::io::NpyReader file_;
  std::uint64_t rows_ = 1, columns_ = 0;
};

[[noreturn]] void fail(const std::string& source, const std::string& text) {
  throw mtf::UsageError(one_line(source) + ": " + text);
}

/// The tables of a folder, or one table, and the times beside them.
struct Files {
  std::string times, fronts, backs;  ///< no `backs`: one table
  explicit Files(const std::string& path) {
    std::error_code ignored;
    const bool folder = fs::is_directory(path, ignored);
    const fs::path beside = folder ? fs::path(path) : fs::path(path).parent_path();
    times = (beside / "times.csv").string();
    fronts = folder ? (beside / "temperatures.npy").string() : path;
    if (folder) backs = (beside / "temperatures_back.npy").string();
  }
};

/// The instants (UTC, s) of the times.csv that `mtf heat` writes beside tables of that many rows.
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

/// The rows that belong to a place, or all.
std::vector<float> values_of(NpyRows& file, const std::string& path, std::size_t facets,
                             const std::optional<TemperatureRows::Place>& place) {
  constexpr std::size_t kMostBytes = std::size_t{4} << 30;
  if (file.columns() != facets)
    fail(path, "has " + std::to_string(file.columns()) + " facets, the scene " + std::to_string(facets) +
                   "; it belongs to another scene");
  const std::uint64_t first = place ? place->row : 0, end = place ? place->next + 1 : file.rows();
  if (end - first > kMostBytes / sizeof(float) / facets)
    fail(path, std::to_string(end - first) + " rows of " + std::to_string(facets) + " facets are more than " +
                   std::to_string(kMostBytes >> 30) + " GiB; give fewer rows");
  return file.values(first, end - first);
}

TemperatureRows read_npy(const std::string& path, const Files& files, std::size_t facets,
                         const std::optional<double>& about_utc_s) {
  NpyRows fronts(files.fronts);
  TemperatureRows rows{.source = path, .facets = facets};
  if (!files.backs.empty() || fronts.rows() > 1) rows.utc_s = read_output_times(files.times, fronts.rows());
  std::optional<TemperatureRows::Place> place;
  if (about_utc_s) place = rows.place_of(*about_utc_s), rows.first = place->row;
  rows.front_k = values_of(fronts, path, facets, place);
  if (std::error_code ignored; fs::exists(files.backs, ignored)) {
    NpyRows backs(files.backs);
    if (backs.rows() != fronts.rows())
      fail(files.backs, std::to_string(backs.rows()) + " times, where " + one_line(files.fronts) + " has " +
                            std::to_string(fronts.rows()) + "; they are of two runs: run mtf heat again");
    rows.back_k = values_of(backs, path, facets, place);
  }
  return rows;
}

TemperatureRows read_csv(const std::string& path, std::size_t facets) {
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
  TemperatureRows rows{.source = path, .facets = facets};
  rows.front_k.assign(facets, std::numeric_limits<float>::quiet_NaN());
  for (std::size_t i = 0; i < numbers.line.size(); ++i) {
    const double facet = numbers.column[0][i];
    const std::string where = ":" + std::to_string(numbers.line[i]) + ": error: ";
    if (!(facet >= 0.0 && facet < static_cast<double>(facets)) || facet != std::floor(facet))
      throw mtf::UsageError(one_line(path) + where + "the scene has no such facet; it has " + std::to_string(facets));
    float& kelvin = rows.front_k[static_cast<std::size_t>(facet)];
    if (!std::isnan(kelvin)) throw mtf::UsageError(one_line(path) + where + "the facet stands twice");
    kelvin = static_cast<float>(numbers.column[1][i]);
    if (!is_temperature(numbers.column[1][i]))
      throw mtf::UsageError(one_line(path) + where + significant(numbers.column[1][i], 4) +
                            " K, which no surface has; it has to be above 0 and no more than 3000 K");
  }
  return rows;
}

}  // namespace

TemperatureRows read_temperatures(const std::string& path, std::size_t facets, std::optional<double> about_utc_s) {
  const Files files(path);
  TemperatureRows rows =
      files.fronts.ends_with(".npy") ? read_npy(path, files, facets, about_utc_s) : read_csv(path, facets);
  for (const std::vector<float>* side : {&rows.front_k, &rows.back_k})
    for (std::size_t i = 0; i < side->size(); ++i)
      if (const auto kelvin = static_cast<double>((*side)[i]); !std::isnan(kelvin) && !is_temperature(kelvin))
        fail(path,
             "facet " + std::to_string(i % facets) + " has " + significant(kelvin, 4) + " K, which no surface has");
  return rows;
}

std::vector<std::string> temperature_files(const std::string& path) {
  if (path.empty()) return {};
  const Files files(path);
  return files.backs.empty() ? std::vector{files.times, files.fronts}
                             : std::vector{files.times, files.fronts, files.backs};
}

}  // namespace apps::scene
