// SPDX-License-Identifier: Apache-2.0
#include "mtf/io/csv/field_map_csv.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "mtf/error.h"
#include "mtf/field/field_map.h"
#include "mtf/io/csv/csv_cells.h"
#include "mtf/io/csv/csv_numbers.h"
#include "mtf/words.h"

namespace mtf::io {
namespace {

const std::string kMapRemedy = "write the first line like this: r (deg),w131,w222 or x (mm),y (mm),w131,w222";

struct MapHeader {
  std::string name;
  const Unit* unit = nullptr;
};

/// "rms (urad)", "rms [urad]", "rms_urad"; "zernike[3]" has no unit.
MapHeader map_header(std::string_view cell, const std::string& where) {
  const std::size_t open = cell.find_first_of("([");
  if (open != std::string_view::npos && cell.find_first_not_of("0123456789", open + 1) != cell.size() - 1) {
    const std::string_view inside = trimmed_cell(cell.substr(open + 1, cell.find_first_of(")]", open) - open - 1));
    const Unit* unit = find_unit(inside);
    if (unit == nullptr && !inside.empty())
      throw UsageError(where + "unknown unit in \"" + printable(cell, 40) + "\"; " + kMapRemedy);
    return {lower_case(trimmed_cell(cell.substr(0, open))), unit};
  }
  const std::size_t end = cell.rfind('_');
  const Unit* unit = end == std::string_view::npos ? nullptr : find_unit(cell.substr(end + 1));
  return {lower_case(unit == nullptr ? cell : cell.substr(0, end)), unit};
}

/// The unit of positions and the factor to it; of angles, whose tangents count, to radians.
std::pair<FieldUnit, double> field_unit(const Unit* unit, const std::string& where) {
  if (unit == nullptr) return {FieldUnit::half_diagonal, 1.0};
  if (unit->dimension == Dimension::length) return {FieldUnit::millimetre, convert({1.0, unit}, "mm")};
  if (unit->dimension == Dimension::angle) return {FieldUnit::slope, convert({1.0, unit}, "rad")};
  if (unit->dimension == Dimension::pixel) return {FieldUnit::pixel, 1.0};
  throw UsageError(where + "positions in " + std::string(unit->name) +
                   "; they are lengths (mm), angles (deg), px, or shares of half the diagonal, without a unit");
}

/// The cells of a column in the given lines.
std::vector<std::string> cells_of(std::string_view text, const std::vector<std::size_t>& lines, std::size_t column) {
  std::vector<std::string> cells;
  std::optional<char> separator;  // that of the header
  text = without_mark(text);
  for (std::size_t line = 1; !text.empty(); ++line) {
    const std::string_view row = take_text_line(text);
    if (!separator && !is_comment(row)) separator = separator_of(row);
    if (cells.size() < lines.size() && lines[cells.size()] == line)
      cells.emplace_back(split_cells(row, *separator).at(column));
  }
  return cells;
}

/// Positions and columns as the text has them, and where `with_files` the cells of the column `file`.
FieldFiles read_positions(std::string_view text, const std::string& source, bool with_files) {
  FieldMap map;
  map.source = source;
  std::vector<FieldMap::Column>& columns = map.column;
  std::vector<std::size_t> places;
  std::vector<double> factors;
  std::size_t file = 0;
  const auto index_of = [&](std::string_view name) {
    const auto found = std::ranges::find(columns, name, &FieldMap::Column::name);
    return found == columns.end() ? std::nullopt : std::optional(static_cast<std::size_t>(found - columns.begin()));
  };
  const CsvNumbers numbers =
      read_csv_numbers(text, source, kMapRemedy, [&](const auto& cells, const std::string& where) {
        for (const std::string_view cell : cells) {
          const MapHeader header = map_header(cell, where);
          if (header.name.empty()) throw UsageError(where + "a column has no name; " + kMapRemedy);
          if (index_of(header.name))
            throw UsageError(where + "two columns are called " + printable(header.name, 40) + "; leave one");
          columns.push_back({header.name, header.unit, {}});
        }
        std::vector<std::size_t> chosen(cells.size());
        std::iota(chosen.begin(), chosen.end(), std::size_t{0});
        if (with_files) {
          if (!index_of("file"))
            throw UsageError(where + "no column is called file; write the first line like this: x (mm),y (mm),file");
          file = *index_of("file");
          chosen.erase(chosen.begin() + static_cast<std::ptrdiff_t>(file));
          columns.erase(columns.begin() + static_cast<std::ptrdiff_t>(file));
        }
        const auto r = index_of("r"), x = index_of("x"), y = index_of("y");
        map.radial = r.has_value();
        if (map.radial ? x || y : !x || !y)
          throw UsageError(where + "positions are given by the columns x and y, or by r alone; " + kMapRemedy);
        places = map.radial ? std::vector{*r} : std::vector{*x, *y};
        if (with_files ? places.size() != columns.size() : places.size() == columns.size())
          throw UsageError(where + (with_files ? "there are columns besides the positions and file; leave them out"
                                               : "no column with values; " + kMapRemedy));
        for (const std::size_t i : places) {
          const auto [unit, factor] = field_unit(columns[i].unit, where);
          if (i != places.front() && unit != map.unit)
            throw UsageError(where + "x and y differ in the kind of their units; write both alike");
          map.unit = unit;
          factors.push_back(factor);
        }
        return chosen;
      });
  const auto place = [&](std::size_t axis, std::size_t row) {
    const double value = numbers.column[places[axis]][row] * factors[axis];
    if (map.unit != FieldUnit::slope) return value;
    if (!(std::abs(value) < 0.5 * std::numbers::pi))
      throw UsageError(source + ":" + std::to_string(numbers.line[row]) + ": a field angle of 90 degrees or more");
    return std::tan(value);
  };
  for (std::size_t row = 0; row < numbers.line.size(); ++row)
    map.position.push_back({place(0, row), map.radial ? 0.0 : place(1, row)});
  for (std::size_t i = 0; i < columns.size(); ++i) columns[i].value = numbers.column[i];
  for (const std::size_t i : places) columns[i].name.clear();
  std::erase_if(columns, [](const FieldMap::Column& column) { return column.name.empty(); });
  return {std::move(map), with_files ? cells_of(text, numbers.line, file) : std::vector<std::string>{}};
}

}  // namespace

std::shared_ptr<const FieldMap> parse_field_map_csv(std::string_view text, const std::string& source) {
  return make_field_map(read_positions(text, source, false).positions);
}

std::shared_ptr<const FieldMap> read_field_map_csv(const std::string& path) {
  return parse_field_map_csv(read_table_text(path), path);
}

FieldFiles read_field_files_csv(const std::string& path) { return read_positions(read_table_text(path), path, true); }

}  // namespace mtf::io
