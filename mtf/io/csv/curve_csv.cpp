// SPDX-License-Identifier: Apache-2.0
#include "mtf/io/csv/curve_csv.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <memory>
#include <optional>
#include <system_error>
#include <utility>
#include <vector>

#include "mtf/error.h"
#include "mtf/io/csv/csv_cells.h"
#include "mtf/io/csv/csv_numbers.h"
#include "mtf/io/csv/curve_samples.h"
#include "mtf/io/csv/spectral_units.h"
#include "mtf/io/file_checks.h"
#include "mtf/io/image_io.h"
#include "mtf/words.h"

namespace mtf::io {
namespace {

const std::string kHeaderRemedy = "write the first line like this: frequency_cy_mm,mtf (or _cy_mrad, _cy_px)";

struct Frequency {
  bool is = false;
  const Unit* unit = nullptr;  ///< null: none given
  std::string rest;            ///< what is in place of the unit
};

/// "frequency_cy_mm", "Spatial freq. [lp/mm]", or the unit alone, "Cy/Pxl".
Frequency frequency_column(std::string_view cell) {
  std::string rest = plain_words(cell);
  const auto take = [&](std::string_view word) {
    const bool is = rest == word || (rest.starts_with(word) && rest[word.size()] == '_');
    if (is) rest.erase(0, std::min(rest.size(), word.size() + 1));
    return is;
  };
  take("spatial");
  Frequency found{.is = take("frequency") || take("freq") || take("f"), .unit = nullptr, .rest = rest};
  for (const std::string_view per : {"cy_", "cycles_", "cycles_per_", "cyc_", "c_", "lp_"}) {
    if (!rest.starts_with(per)) continue;
    const std::string what = rest.substr(per.size());
    if (what == "mm" || what == "mrad") found.unit = find_unit("cy/" + what);
    if (what == "px" || what == "pixel" || what == "pxl") found.unit = find_unit("cy/px");
  }
  found.is = found.is || found.unit != nullptr || rest == "lw_ph";
  return found;
}

struct CurveColumns {
  std::size_t frequency = 0, value = 0;
  const Unit* unit = nullptr;
};

CurveColumns choose_columns(const std::vector<std::string_view>& cells, const std::string& where) {
  const auto fail = [&](const std::string& why) { return UsageError(where + why + "; " + kHeaderRemedy); };
  CurveColumns columns;
  std::vector<std::size_t> frequencies, values;
  std::string names;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    names += (i > 0 ? ", " : "") + printable(cells[i], 40);
    if (frequency_column(cells[i]).is) frequencies.push_back(i);
    if (plain_words(cells[i]) == "mtf") values.push_back(i);
  }
  if (frequencies.empty()) throw fail("no column is called frequency (found: " + printable(names) + ")");
  if (frequencies.size() > 1) throw UsageError(where + "more than one frequency column; leave one");
  columns.frequency = frequencies.front();
  if (cells.size() == 2) {
    columns.value = 1 - columns.frequency;
  } else {
    if (values.size() != 1)
      throw fail(std::to_string(cells.size()) +
                 " columns, and not exactly one of them is called mtf (found: " + printable(names) + ")");
    columns.value = values.front();
  }
  const Frequency found = frequency_column(cells[columns.frequency]);
  columns.unit = found.unit;
  if (found.rest == "lw_ph")
    throw UsageError(where +
                     "line widths per picture height count the rows of an image that is not known here: divide " +
                     "them by twice its rows, and call them frequency_cy_px");
  if (columns.unit == nullptr)
    throw fail(found.rest.empty()
                   ? "the frequency has no unit"
                   : "unknown unit of the frequency, \"" + printable(cells[columns.frequency], 40) + "\"");
  return columns;
}

RuntimeError no_text(const std::string& path) {
  return RuntimeError("cannot read " + path +
                      ": it is an image, and a text file belongs here; are two files in each other's place?");
}

std::string read_whole(const std::string& path, std::size_t limit, bool text_belongs_here) {
  static_cast<void>(ordinary_file_size(path));
  const auto close = [](std::FILE* file) { static_cast<void>(std::fclose(file)); };
  const std::unique_ptr<std::FILE, decltype(close)> file(std::fopen(path.c_str(), "rb"), close);
  if (!file)
    throw RuntimeError("cannot read " + path + ": " + std::generic_category().message(errno) + "; check the path");
  std::string text;
  std::array<char, 65536> buffer{};
  while (const std::size_t n = std::fread(buffer.data(), 1, buffer.size(), file.get())) {
    text.append(buffer.data(), n);
    if (text.size() > limit && text_belongs_here && format_of(text)) throw no_text(path);
    if (text.size() > limit)
      throw RuntimeError("cannot read " + path + ": larger than " + shown_bytes(static_cast<double>(limit)) +
                         ", the limit for this kind of file; is it the right one?");
  }
  if (std::ferror(file.get()))
    throw RuntimeError("cannot read " + path + ": " + std::generic_category().message(errno));
  if (text_belongs_here && format_of(text)) throw no_text(path);
  return text;
}

constexpr std::size_t kMaxSampleColumns = 256;
constexpr std::size_t kMapperSamples = 64;

/// The file's rows as cells, with what messages call each.
struct Table {
  std::vector<std::string_view> header;
  std::vector<std::vector<std::string_view>> rows;
  std::vector<std::string> where;

  std::optional<std::size_t> column(std::string_view name) const {
    const auto at = std::ranges::find(header, name, plain_words);
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

/// The columns that stand before those of the curve in a file edge_sfr_values.txt of MTF Mapper, which names them in
/// comments from its output version 2 on; 0 for another text. The first version has five, and no comments.
std::size_t mtf_mapper_columns(std::string_view text) {
  constexpr std::size_t first_version = 5;
  if (text.starts_with("# MTF Mapper SFR")) {
    std::size_t columns = 0;
    while (text.starts_with('#')) columns += take_text_line(text).starts_with("# column") ? 1 : 0;
    return columns;
  }
  const auto cells = split_words(take_text_line(text));
  const bool numbers =
      std::ranges::all_of(cells, [](std::string_view cell) { return cell_number<double>(cell).has_value(); });
  return numbers && cells.size() == first_version + kMapperSamples ? first_version : 0;
}

/// An edge a row: columns that describe it, then its curve at 0, 1/64, ... 63/64 cy/px.
std::vector<CurveSamples> mtf_mapper_curves(std::string_view text, std::size_t columns, const std::string& source) {
  std::vector<CurveSamples> all;
  for (std::size_t line = 1; !text.empty(); ++line) {
    const std::string_view row = take_text_line(text);
    if (is_comment(row)) continue;
    const auto cells = split_words(row);
    const std::string where = source + ":" + std::to_string(line) + ": ";
    if (cells.size() != columns + kMapperSamples)
      throw UsageError(where + "a row of MTF Mapper has " + std::to_string(columns) + " columns and " +
                       std::to_string(kMapperSamples) + " samples; here are " + std::to_string(cells.size()) +
                       " numbers");
    CurveSamples& curve = all.emplace_back();
    curve.name = "edge at " + printable(cells[1], 20) + "," + printable(cells[2], 20);
    curve.unit = find_unit("cy/px");
    for (std::size_t i = 1; i < kMapperSamples; ++i) {  // the first is 1 by definition
      const auto value = cell_number<double>(cells[columns + i]);
      if (!value || !std::isfinite(*value))
        throw UsageError(where + "\"" + printable(cells[columns + i], 20) + "\" is no number");
      curve.frequency.push_back(static_cast<double>(i) / static_cast<double>(kMapperSamples));
      curve.mtf.push_back(*value);
    }
    if (cell_number<double>(cells[columns]) == 0.0) all.pop_back();  // an edge that could not be measured
  }
  return all;
}

constexpr int kNoRank = 9;

/// What is called MTF or SFR first, then the luminance, then colours.
int mtf_rank(std::string_view cell) {
  std::string name = plain_words(cell);
  if (name == "mtf" || name == "sfr") return 0;
  const bool is_channel = name.starts_with("mtf_") || name.starts_with("sfr_");
  if (is_channel) name.erase(0, 4);
  if (name == "lum" || (is_channel && (name == "y" || name == "luminance"))) return 1;
  constexpr std::array<std::string_view, 6> colours{"r", "red", "g", "green", "b", "blue"};
  return is_channel && std::ranges::find(colours, name) != colours.end() ? 2 : kNoRank;
}

/// Cycles per pixel first, and what has no unit last.
int frequency_rank(std::string_view cell) {
  const Frequency found = frequency_column(cell);
  return !found.is ? kNoRank : found.unit == nullptr ? 2 : found.unit->name == "cy/px" ? 0 : 1;
}

/// Cells of a line, in which a comma between quotes separates nothing.
std::vector<std::string> quoted_cells(std::string_view line) {
  std::string text(line);
  bool inside = false;
  for (char& c : text) {
    if (c == '"') inside = !inside;
    if (c == ',' && inside) c = ' ';
  }
  std::vector<std::string> cells;
  for (const std::string_view cell : split_cells(text, separator_of(text), kMaxSampleColumns)) cells.emplace_back(cell);
  return cells;
}

/// The cells of the least rank; empty where none has one.
std::vector<std::size_t> foremost(const std::vector<std::string>& cells, int (*rank_of)(std::string_view)) {
  std::vector<std::size_t> found;
  int least = kNoRank;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const int rank = rank_of(cells[i]);
    if (rank < least) found.clear(), least = rank;
    if (rank == least && rank < kNoRank) found.push_back(i);
  }
  return found;
}

struct InstrumentTable {
  std::string csv;     ///< frequency, MTF and sd, on the lines where they stood; all other lines are comments
  std::string column;  ///< whose MTF is taken
};

/// Whether a row of cells ends the table: blank, or the name of what follows stands in place of the frequency. A value
/// without its frequency does not.
bool ends_table(const std::vector<std::string>& cells, std::size_t frequency, std::size_t value) {
  const std::string& cell = cells[frequency < cells.size() ? frequency : 0];
  if (cell.empty()) return value >= cells.size() || !cell_number(cells[value]);
  return !cell_number(cell) && std::isalpha(static_cast<unsigned char>(cell[0]));
}

/// Of a file that other instruments write, whose columns it chooses; nothing where the text is none.
std::optional<InstrumentTable> instrument_table(std::string_view text, const std::string& source) {
  InstrumentTable table;
  std::vector<std::size_t> frequency, value, chosen;
  std::size_t count = 0;  // of the columns
  bool first = true;
  for (std::size_t line = 1; !text.empty(); ++line, table.csv += '\n') {
    const std::string_view row = take_text_line(text);
    if (table.column.empty() && (is_comment(row) || cell_number(row.substr(0, 1)))) continue;  // numbers are no header
    const std::vector<std::string> cells = quoted_cells(row);
    if (!table.column.empty()) {
      if (ends_table(cells, frequency[0], value[0])) break;
      std::string kept;
      for (const std::size_t i : chosen)
        if (i < cells.size()) kept += (i == chosen[0] ? "" : ",") + cells[i];
      for (std::size_t i = count; i < cells.size(); ++i)
        if (!cells[i].empty()) kept += "," + cells[i];  // too many: refused there
      table.csv += kept;
      continue;
    }
    frequency = foremost(cells, frequency_rank);
    value = foremost(cells, mtf_rank);
    const bool is_first = std::exchange(first, false);
    if (frequency.empty() || value.empty()) continue;
    if (is_first && std::ranges::count_if(cells, [](const auto& cell) { return frequency_column(cell).is; }) == 1 &&
        plain_words(cells[value[0]]) == "mtf")
      return std::nullopt;  // frequency_cy_mm,mtf and what may stand beside them
    if (value.size() > 1)
      throw UsageError(source + ":" + std::to_string(line) + ": columns " +
                       joined(value, [&](std::size_t i) { return printable(cells[i], 20); }) +
                       " and none of the luminance; leave the one to be fitted");
    count = cells.size();
    chosen = {frequency[0], value[0]};
    table.column = printable(cells[value[0]], 20);
    table.csv += cells[frequency[0]];
    std::ranges::replace(table.csv, ',', ' ');
    table.csv += ",mtf";
    for (std::size_t i = 0; i < count && chosen.size() == 2; ++i)
      if (const std::string name = plain_words(cells[i]);
          name == "sd" || name == "mtf_sd" || name == plain_words(table.column) + "_sd")
        chosen.push_back(i), table.csv += ",sd";
  }
  return table.column.empty() ? std::nullopt : std::optional(std::move(table));
}

}  // namespace

std::string read_file(const std::string& path, std::size_t limit) { return read_whole(path, limit, false); }
std::string read_text_file(const std::string& path, std::size_t limit) { return read_whole(path, limit, true); }

Curve parse_curve_csv(std::string_view text, const std::string& source) {
  const Unit* unit = nullptr;
  CsvNumbers numbers = read_csv_numbers(text, source, kHeaderRemedy, [&](const auto& cells, const std::string& where) {
    const CurveColumns columns = choose_columns(cells, where);
    unit = columns.unit;
    return std::vector{columns.frequency, columns.value};
  });
  std::vector<double>&frequency = numbers.column[0], &value = numbers.column[1];
  for (std::size_t i = 0; i < frequency.size(); ++i) {
    const auto fail = [&](const std::string& why) {
      return UsageError(source + ":" + std::to_string(numbers.line[i]) + ": " + why);
    };
    const double f = frequency[i], v = value[i];
    if (f < 0.0) throw fail("negative frequency " + format_double(f) + "; MTFs start at 0");
    if (i > 0 && f <= frequency[i - 1])
      throw fail("frequency " + format_double(f) + " after " + format_double(frequency[i - 1]) +
                 "; frequencies have to increase");
    if (std::abs(v) > 1.05) throw fail("|MTF| " + format_double(v) + " above 1.05; divide by 100 if it is in percent");
  }
  return make_curve(source, *unit, std::move(frequency), std::move(value));
}

Curve read_curve_csv(const std::string& path) { return parse_curve_csv(read_table_text(path), path); }

std::vector<CurveSamples> parse_curve_samples(std::string_view text, const std::string& source, const Unit* bare) {
  text = without_mark(text);
  const std::size_t mapper = mtf_mapper_columns(text);
  const auto instrument = mapper > 0 ? std::nullopt : instrument_table(text, source);
  if (instrument) text = instrument->csv;
  const Table table = mapper > 0 ? Table{} : split(text, source);
  std::vector<CurveSamples> curves;
  if (mapper > 0) {
    curves = mtf_mapper_curves(text, mapper, source);
  } else if (const auto kind = table.column("curve");
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
    } else if (instrument && one.frequency.front() == 0.0) {  // where it is 1 by definition
      one.frequency.erase(one.frequency.begin());
      one.mtf.erase(one.mtf.begin());
    }
    if (instrument) one.name = "column " + instrument->column;
  }
  std::erase_if(curves, [](const CurveSamples& curve) { return curve.frequency.empty(); });
  if (curves.empty())
    throw UsageError(source + ": no sample of an MTF with a standard deviation above 0; leave the column sd out to " +
                     "have --curve-sd for all");
  return curves;
}

bool is_curve_header(std::string_view line) {
  const std::vector<std::string> cells = quoted_cells(line);
  return !foremost(cells, frequency_rank).empty() && !foremost(cells, mtf_rank).empty();
}

}  // namespace mtf::io
