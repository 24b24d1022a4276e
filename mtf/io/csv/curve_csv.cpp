// SPDX-License-Identifier: Apache-2.0
#include "mtf/io/csv/curve_csv.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <memory>
#include <optional>
#include <system_error>
#include <vector>

#include "mtf/error.h"
#include "mtf/io/csv/csv_cells.h"
#include "mtf/io/csv/csv_numbers.h"
#include "mtf/io/csv/spectral_units.h"
#include "mtf/io/file_checks.h"
#include "mtf/io/image_io.h"
#include "mtf/words.h"

namespace mtf::io {
namespace {

constexpr std::string_view kHeaderRemedy = "write the first line like this: frequency_cy_mm,mtf (or _cy_mrad, _cy_px)";

struct Frequency {
  bool is = false;
  const Unit* unit = nullptr;  ///< null: none given
  std::string rest;            ///< what is in place of the unit
};

Frequency frequency_column(std::string_view cell) {
  const std::string name = plain_words(cell);
  const std::size_t end = std::min(name.find('_'), name.size());
  const std::string word = name.substr(0, end);
  if (word != "frequency" && word != "freq" && word != "f" && word != "spatial") return {};
  std::string rest = end < name.size() ? name.substr(end + 1) : "";
  if (word == "spatial") {
    if (!rest.starts_with("frequency")) return {};
    rest = rest.size() > 9 ? rest.substr(10) : "";
  }
  Frequency found{.is = true, .unit = nullptr, .rest = rest};
  for (const std::string_view per : {"cy_", "cycles_", "cycles_per_", "cyc_", "c_", "lp_"}) {
    if (!rest.starts_with(per)) continue;
    const std::string what = rest.substr(per.size());
    if (what == "mm" || what == "mrad") found.unit = find_unit("cy/" + what);
    if (what == "px" || what == "pixel") found.unit = find_unit("cy/px");
  }
  return found;
}

struct CurveColumns {
  char separator = ',';
  std::size_t count = 0, frequency = 0, value = 0;
  const Unit* unit = nullptr;
};

CurveColumns read_header(std::string_view line, const std::string& where) {
  const auto fail = [&](const std::string& why) { return UsageError(where + why + "; " + std::string(kHeaderRemedy)); };
  CurveColumns columns;
  columns.separator = separator_of(line);
  const auto cells = split_cells(line, columns.separator, kMaxTableColumns);
  columns.count = cells.size();
  if (cell_number(cells.front())) throw fail("the header is missing");
  if (cells.size() < 2) throw fail("one column only, two are needed (separator: comma, semicolon or tab)");
  if (cells.size() > kMaxTableColumns)
    throw UsageError(where + "more than " + std::to_string(kMaxTableColumns) + " columns");
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

}  // namespace

std::string read_file(const std::string& path, std::size_t limit) { return read_whole(path, limit, false); }
std::string read_text_file(const std::string& path, std::size_t limit) { return read_whole(path, limit, true); }

Curve parse_curve_csv(std::string_view text, const std::string& source) {
  text = without_mark(text);
  std::optional<CurveColumns> columns;
  std::vector<double> frequency, value;
  for (std::size_t line = 1; !text.empty(); ++line) {
    const std::string_view row = take_text_line(text);
    if (is_comment(row)) continue;
    const std::string where = source + ":" + std::to_string(line) + ": ";
    if (!columns) {
      columns = read_header(row, where);
      continue;
    }
    const auto fail = [&](const std::string& why) { return UsageError(where + why); };
    const auto cells = split_cells(row, columns->separator, kMaxTableColumns);
    if (cells.size() != columns->count)
      throw fail(std::to_string(cells.size()) + " values where the header has " + std::to_string(columns->count) +
                 "; numbers have a decimal point, not a comma");
    const auto cell = [&](std::size_t i) {
      const auto number_there = cell_number(cells[i]);
      if (!number_there || !std::isfinite(*number_there))
        throw fail("\"" + printable(cells[i], 40) + "\" is no finite number; write it like 0.93");
      return *number_there;
    };
    const double f = cell(columns->frequency), v = cell(columns->value);
    if (f < 0.0) throw fail("negative frequency " + format_double(f) + "; MTFs start at 0");
    if (!frequency.empty() && f <= frequency.back())
      throw fail("frequency " + format_double(f) + " after " + format_double(frequency.back()) +
                 "; frequencies have to increase");
    if (std::abs(v) > 1.05) throw fail("|MTF| " + format_double(v) + " above 1.05; divide by 100 if it is in percent");
    if (frequency.size() == kMaxTableRows) throw fail("more than a million rows; thin the curve out");
    frequency.push_back(f);
    value.push_back(v);
  }
  if (!columns) throw UsageError(source + ": no header and no data; " + std::string(kHeaderRemedy));
  return make_curve(source, *columns->unit, std::move(frequency), std::move(value));
}

Curve read_curve_csv(const std::string& path) { return parse_curve_csv(read_table_text(path), path); }

}  // namespace mtf::io
