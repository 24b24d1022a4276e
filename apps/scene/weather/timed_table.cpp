// SPDX-License-Identifier: Apache-2.0
#include "apps/scene/weather/timed_table.h"

#include <cmath>
#include <limits>

#include "mtf/error.h"
#include "mtf/io/csv/csv_cells.h"
#include "mtf/words.h"
#include "radiometry/weather/instant.h"

namespace apps::scene {
namespace {

using mtf::printable;

/// "air_temperature (degC)" or "air_temperature [degC]" in its two parts.
struct HeaderCell {
  std::string name, unit;
};

HeaderCell header_cell(std::string_view cell) {
  const std::size_t open = cell.find_first_of("([");
  HeaderCell parts{std::string(mtf::io::trimmed_cell(cell.substr(0, open))), {}};
  if (open == std::string_view::npos) return parts;
  const std::size_t close = cell.find_last_of(")]");
  if (close != std::string_view::npos && close > open) parts.unit = cell.substr(open + 1, close - open - 1);
  return parts;
}

class TableReader {
 public:
  TableReader(const std::string& source, double origin_s) : source_(source), origin_s_(origin_s) {}

  TimedTable read(std::string_view text) {
    text = mtf::io::without_mark(text);
    for (line_ = 1; !text.empty(); ++line_) {
      const std::string_view row = mtf::io::take_text_line(text);
      if (mtf::io::is_comment(row)) continue;
      if (table_.header_line == 0)
        read_header(row);
      else
        read_record(row);
    }
    if (table_.header_line == 0)
      throw mtf::UsageError(source_ + ": error: the table is empty; its first line has to name the columns: time, ...");
    if (table_.time_s.empty()) throw mtf::UsageError(source_ + ": error: a header and no records; add at least one");
    return std::move(table_);
  }

 private:
  [[noreturn]] void fail(const std::string& text) const { throw mtf::UsageError(error_at(source_, line_) + text); }

  void read_header(std::string_view row) {
    table_.header_line = line_;
    separator_ = mtf::io::separator_of(row);
    const auto cells = mtf::io::split_cells(row, separator_);
    const HeaderCell time = header_cell(cells.front());
    if (time.name != "time")
      fail("the first column is \"" + printable(cells.front(), 40) +
           "\"; it has to be time, as ISO 8601 with a zone, or time (s) from the start of the run");
    if (cells.size() < 2) fail("the table has no column but time (separators are comma, semicolon and tab)");
    if (cells.size() > mtf::io::kMaxTableColumns)
      fail("more than " + std::to_string(mtf::io::kMaxTableColumns) + " columns");
    if (!time.unit.empty()) {
      const auto unit = parse_unit(time.unit);
      if (!unit || !same_dimension(*unit, parse_unit("s").value()))
        fail("time (" + printable(time.unit, 20) + ") has no unit of time; write time (s), time (min) or time (h)");
      time_unit_s_ = unit->factor;
    }
    for (std::size_t i = 1; i < cells.size(); ++i) {
      const HeaderCell cell = header_cell(cells[i]);
      if (cell.name.empty()) fail("column " + std::to_string(i + 1) + " has no name");
      if (cell.unit.empty())
        fail("column \"" + printable(cell.name, 40) + "\" has no unit; write it in brackets: " +
             printable(cell.name, 40) + " (degC), (m/s), (W/m2), (hPa), (%)");
      const auto unit = parse_unit(cell.unit);
      if (!unit) fail("column \"" + printable(cell.name, 40) + "\": unknown unit \"" + printable(cell.unit, 40) + "\"");
      for (const TimedColumn& other : table_.columns)
        if (other.name == cell.name) fail("column \"" + printable(cell.name, 40) + "\" stands twice");
      table_.columns.push_back({cell.name, *unit, {}});
    }
  }

  double time_of(std::string_view cell) const {
    if (time_unit_s_) {
      const auto value = mtf::io::cell_number(cell);
      if (!value || !std::isfinite(*value)) fail("time \"" + printable(cell, 40) + "\" is no number");
      return origin_s_ + *value * *time_unit_s_;
    }
    radiometry::heat::InstantError error;
    const auto instant = radiometry::heat::parse_instant(cell, error);
    if (!instant) fail("time \"" + printable(cell, 40) + "\": " + error.text);
    return *instant;
  }

  void read_record(std::string_view row) {
    const auto cells = mtf::io::split_cells(row, separator_);
    if (cells.size() != table_.columns.size() + 1)
      fail(std::to_string(cells.size()) + " values where the header has " + std::to_string(table_.columns.size() + 1) +
           "; numbers have a decimal point, not a comma");
    if (table_.time_s.size() == mtf::io::kMaxTableRows) fail("more than a million records; thin the table out");
    table_.time_s.push_back(time_of(cells.front()));
    table_.line.push_back(line_);
    for (std::size_t i = 0; i < table_.columns.size(); ++i) {
      TimedColumn& column = table_.columns[i];
      const std::string_view cell = cells[i + 1];
      double value = std::numeric_limits<double>::quiet_NaN();
      if (!cell.empty() && cell != "nan" && cell != "NaN") {
        const auto number = mtf::io::cell_number(cell);
        if (!number || !std::isfinite(*number))
          fail("\"" + printable(cell, 40) + "\" in the column " + printable(column.name, 40) +
               " is no number; leave the cell empty where the value is missing");
        value = *number * column.unit.factor + column.unit.offset;
      }
      column.value.push_back(value);
    }
  }

  const std::string& source_;
  double origin_s_;
  std::size_t line_ = 0;
  char separator_ = ',';
  std::optional<double> time_unit_s_;
  TimedTable table_;
};

}  // namespace

std::string error_at(const std::string& source, std::size_t line) {
  return source + ":" + std::to_string(line) + ": error: ";
}

TimedTable parse_timed_table(std::string_view text, const std::string& source, double origin_s) {
  return TableReader(source, origin_s).read(text);
}

}  // namespace apps::scene
