// SPDX-License-Identifier: Apache-2.0
#include "mtf/io/csv/curve_samples.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "mtf/error.h"
#include "mtf/io/csv/csv_cells.h"
#include "mtf/io/csv/csv_numbers.h"
#include "mtf/io/csv/curve_csv.h"
#include "mtf/words.h"

namespace mtf::io {
namespace {

constexpr std::size_t kMaxSampleColumns = 256;

/// The file's rows as cells, with what messages call each.
struct Table {
  std::vector<std::string_view> header;
  std::vector<std::vector<std::string_view>> rows;
  std::vector<std::string> where;

  std::optional<std::size_t> column(std::string_view name) const {
    const auto at = std::find(header.begin(), header.end(), name);
    return at == header.end() ? std::nullopt : std::optional(static_cast<std::size_t>(at - header.begin()));
  }
};

Table split(std::string_view text, const std::string& source) {
  Table table;
  text = without_mark(text);
  char separator = ',';
  for (std::size_t line = 1; !text.empty(); ++line) {
    const std::string_view row = take_text_line(text);
    if (is_comment(row)) continue;
    if (table.header.empty()) separator = separator_of(row);
    auto cells = split_cells(row, separator, kMaxSampleColumns);
    const std::string where = source + ":" + std::to_string(line) + ": ";
    if (table.header.empty()) {
      table.header = std::move(cells);
      continue;
    }
    if (cells.size() != table.header.size())
      throw UsageError(where + std::to_string(cells.size()) + " values where the header has " +
                       std::to_string(table.header.size()) + "; numbers have a decimal point, not a comma");
    table.rows.push_back(std::move(cells));
    table.where.push_back(where);
  }
  return table;
}

double number(const Table& table, std::size_t row, std::size_t column) {
  const std::string_view cell = table.rows[row][column];
  const auto value = cell_number(cell);
  if (!value || !std::isfinite(*value))
    throw UsageError(table.where[row] + "\"" + printable(cell, 40) + "\" is no finite number; write it like 0.93");
  return *value;
}

/// The frequency and one or two value columns, read as a file of these alone: its rules and messages hold.
Curve two_columns(const Table& table, std::size_t frequency, std::size_t value, const Unit* bare,
                  const std::string& source) {
  std::string text(table.header[frequency]);
  if (text == "frequency") {
    if (bare == nullptr)
      throw UsageError(source + ": the frequency has no unit; say what mtf curve was asked for: --curve-unit cy/mm, " +
                       "cy/mrad or cy/px");
    text += "_" + std::string(bare->name);
  }
  text += ",mtf\n";
  for (std::size_t i = 0; i < table.rows.size(); ++i)
    text += format_double(number(table, i, frequency)) + "," + format_double(number(table, i, value)) + "\n";
  return parse_curve_csv(text, source);
}

/// Keeps the samples that have a standard deviation.
void add_sd(CurveSamples& curve, const std::vector<double>& sd) {
  CurveSamples kept{curve.name, curve.unit, {}, {}, {}};
  for (std::size_t i = 0; i < sd.size(); ++i) {
    if (!(sd[i] > 0.0)) continue;
    kept.frequency.push_back(curve.frequency[i]);
    kept.mtf.push_back(curve.mtf[i]);
    kept.sd.push_back(sd[i]);
  }
  curve = std::move(kept);
}

double sd_of(const Table& table, std::size_t row, std::size_t column) {
  if (table.rows[row][column].empty()) return 0.0;
  const double sd = number(table, row, column);
  if (sd < 0.0) throw UsageError(table.where[row] + "the standard deviation " + format_double(sd) + " is negative");
  return sd;
}

/// Of the frequency in a row of `mtf measure --curves`.
const Unit* unit_of_row(const Table& table, std::size_t row, std::optional<std::size_t> column) {
  if (!column) return find_unit("cy/px");
  const std::string_view text = table.rows[row][*column];
  const Unit* unit = find_unit(text == "lp/mm" ? "cy/mm" : text);
  if (unit == nullptr || unit->dimension != Dimension::frequency)
    throw UsageError(table.where[row] + "frequencies in \"" + printable(text, 40) +
                     "\" cannot be fitted; measure with --unit cy/px, cy/mm, lp/mm or cy/mrad");
  return unit;
}

std::vector<CurveSamples> measured_curves(const Table& table, std::size_t kind) {
  const std::size_t edge = *table.column("edge"), x = *table.column("x"), value = *table.column("value"),
                    sd = *table.column("sd");
  const std::optional<std::size_t> unit = table.column("x_unit");
  std::vector<CurveSamples> all;
  std::string_view present;
  for (std::size_t i = 0; i < table.rows.size(); ++i) {
    if (table.rows[i][kind] != "mtf") continue;
    if (all.empty() || table.rows[i][edge] != present) {
      present = table.rows[i][edge];
      all.push_back({"edge " + printable(present, 20), unit_of_row(table, i, unit), {}, {}, {}});
    }
    if (table.rows[i][value].empty()) continue;  // not measured there
    const double error = sd_of(table, i, sd);
    if (error == 0.0) continue;
    all.back().frequency.push_back(number(table, i, x));
    all.back().mtf.push_back(number(table, i, value));
    all.back().sd.push_back(error);
  }
  return all;
}

}  // namespace

std::vector<CurveSamples> parse_curve_samples(std::string_view text, const std::string& source, const Unit* bare) {
  const Table table = split(text, source);
  std::vector<CurveSamples> curves;
  if (const auto kind = table.column("curve");
      kind && table.column("edge") && table.column("x") && table.column("value") && table.column("sd")) {
    curves = measured_curves(table, *kind);
  } else {
    const auto frequency = std::find_if(table.header.begin(), table.header.end(),
                                        [](std::string_view cell) { return cell.starts_with("frequency"); });
    const auto re = table.column("system_re"), im = table.column("system_im"), system = table.column("system");
    Curve curve;
    if (frequency != table.header.end() && !table.column("mtf") && (system || (re && im))) {
      const auto f = static_cast<std::size_t>(frequency - table.header.begin());
      curve = two_columns(table, f, system ? *system : *re, bare, source);
      for (std::size_t i = 0; i < curve.value.size() && !system; ++i)
        curve.value[i] = std::hypot(curve.value[i], number(table, i, *im));
    } else {
      curve = parse_curve_csv(text, source);
    }
    CurveSamples& one = curves.emplace_back();
    one.unit = curve.unit;
    one.frequency = curve.frequency;
    one.mtf = curve.value;
    const auto sd = table.column("sd") ? table.column("sd") : table.column("mtf_sd");
    if (sd && table.header.size() > 2) {
      std::vector<double> errors;
      for (std::size_t i = 0; i < table.rows.size(); ++i) errors.push_back(sd_of(table, i, *sd));
      add_sd(one, errors);
    }
  }
  std::erase_if(curves, [](const CurveSamples& curve) { return curve.frequency.empty(); });
  if (curves.empty())
    throw UsageError(source + ": no sample of an MTF with a standard deviation above 0; leave the column sd out to " +
                     "have --curve-sd for all");
  return curves;
}

std::vector<CurveSamples> read_curve_samples(const std::string& path, const Unit* bare) {
  return parse_curve_samples(read_table_text(path), path, bare);
}

}  // namespace mtf::io
