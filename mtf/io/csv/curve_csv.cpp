// SPDX-License-Identifier: Apache-2.0
#include "mtf/io/csv/curve_csv.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <memory>
#include <system_error>
#include <vector>

#include "mtf/error.h"
#include "mtf/io/csv/csv_numbers.h"
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

}  // namespace mtf::io
