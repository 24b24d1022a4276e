// SPDX-License-Identifier: Apache-2.0
#include "mtf/io/csv/tape7.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <optional>

#include "mtf/error.h"
#include "mtf/io/csv/csv_cells.h"
#include "mtf/io/csv/csv_numbers.h"
#include "mtf/units.h"
#include "mtf/words.h"

namespace mtf::io {
namespace {

constexpr std::size_t kMaxTape7Bytes = std::size_t{256} << 20;
constexpr std::size_t kMaxRunRows = 2'000'000;
constexpr std::size_t kLongestLine = 4096;

/// Names that hold a blank, so that they are not taken for two columns.
constexpr std::array<std::string_view, 13> kTwoWords{"TOT TRANS", "PTH THRML", "THRML SCT", "SURF EMIS", "SOL SCAT",
                                                     "SING SCAT", "GRND RFLT", "DRCT RFLT", "TOTAL RAD", "REF SOL",
                                                     "DIR EM",    "TOA SUN",   "SOL TR"};

struct Column {
  std::string name;  ///< "TOT TRANS"
  std::size_t begin = 0, end = 0;
};

/// Columns of a header: each ends where its name does.
std::vector<Column> columns_of(std::string_view header) {
  std::string line(header);
  for (char& c : line) c = c == '_' ? ' ' : static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  std::string joined = line;
  for (const std::string_view name : kTwoWords)
    for (std::size_t at = line.find(name); at != std::string::npos; at = line.find(name, at + 1))
      joined[at + name.find(' ')] = '_';
  std::vector<Column> columns;
  for (std::size_t at = joined.find_first_not_of(" \t\r"); at != std::string::npos;) {
    const std::size_t end = std::min(joined.find_first_of(" \t\r", at), joined.size());
    columns.push_back({line.substr(at, end - at), columns.empty() ? 0 : columns.back().end, end});
    at = joined.find_first_not_of(" \t\r", end);
  }
  return columns;
}

const Column* find(const std::vector<Column>& columns, std::string_view name) {
  const auto found = std::ranges::find_if(columns, [&](const Column& c) { return c.name == name; });
  return found == columns.end() ? nullptr : &*found;
}

/// A number as Fortran writes it: "1.5E-05", ".5", and without room for the letter "1.5-105".
std::optional<double> fortran_number(std::string_view cell) {
  if (const auto plain = cell_number(cell)) return plain;
  const std::size_t sign = cell.find_last_of("+-");
  if (sign == std::string_view::npos || sign == 0) return std::nullopt;
  std::string_view mantissa = cell.substr(0, sign);
  if (mantissa.back() == 'E' || mantissa.back() == 'D') mantissa.remove_suffix(1);
  const std::string_view exponent = cell.substr(sign + 1);
  const bool digits = !exponent.empty() && std::ranges::all_of(exponent, [](char c) { return c >= '0' && c <= '9'; });
  if (!digits || !cell_number(mantissa) || mantissa.find_first_of("eE") != std::string_view::npos) return std::nullopt;
  if (const auto value = cell_number(std::string(mantissa) + "E" + std::string(cell.substr(sign)))) return value;
  return cell[sign] == '-' ? std::optional(0.0) : std::nullopt;  // beyond the range of a double
}

/// Reads one run, from its header to its end.
class RunReader {
 public:
  RunReader(std::string_view header, const std::string& where) : columns_(columns_of(header)), where_(where) {
    frequency_ = find(columns_, "FREQ");
    if (find(columns_, "LOS") != nullptr)
      throw UsageError(where_ + "several lines of sight in one run; write one run for each");
    if (const Column* total = find(columns_, "TOT TRANS")) {
      transmission_ = total;
      thermal_ = find(columns_, "PTH THRML");
      solar_ = find(columns_, "SOL SCAT");
    } else if (const Column* combined = find(columns_, "COMBIN")) {
      transmission_ = combined;
      second_header_ = true;
    } else {
      transmission_ = find(columns_, "TRANS");
    }
    if (frequency_ == nullptr || transmission_ == nullptr || ((thermal_ == nullptr) != (solar_ == nullptr)))
      throw UsageError(where_ + "a header with FREQ, but not with TOT_TRANS, PTH_THRML and SOL_SCAT, nor COMBIN, nor " +
                       "TRANS: \"" + printable(header, 80) + "\"; is it a tape7 of MODTRAN?");
  }

  RunReader(const RunReader&) = delete;  // points into itself
  RunReader& operator=(const RunReader&) = delete;

  void add(std::string_view row, const std::string& where) {
    if (second_header_) {
      second_header_ = false;
      if (row.find("TRANS") == std::string_view::npos)
        throw UsageError(where + "the second line of the header, with TRANS, is missing");
      return;
    }
    if (wavenumber_.size() == kMaxRunRows)
      throw UsageError(where + "more than " + std::to_string(kMaxRunRows) + " rows in a run; is it a tape7?");
    const double wavenumber = number(row, *frequency_, where, false);
    if (!(wavenumber > 0.0))
      throw UsageError(where + "a wavenumber of " + format_double(wavenumber) + " cm^-1; it has to be above 0");
    if (!wavenumber_.empty() && wavenumber <= wavenumber_.back())
      throw UsageError(where + "wavenumber " + format_double(wavenumber) + " after " +
                       format_double(wavenumber_.back()) + "; they have to increase");
    const double transmission = number(row, *transmission_, where, false);
    if (!(transmission >= 0.0 && transmission <= 1.0))
      throw UsageError(where + transmission_->name + " is " + format_double(transmission) +
                       "; a transmission is from 0 to 1");
    wavenumber_.push_back(wavenumber);
    transmissions_.push_back(transmission);
    if (thermal_ == nullptr) return;
    const double radiance = number(row, *thermal_, where, true) + number(row, *solar_, where, true);
    if (!(radiance >= 0.0)) throw UsageError(where + "a negative radiance of the path, " + format_double(radiance));
    radiances_.push_back(radiance * wavenumber * wavenumber);  // 1e4 cm^2 m^-2, 1e-4 k^2 per um
  }

  Tape7Run finish(const std::string& where, const std::string& source) {
    if (second_header_ || wavenumber_.empty()) throw UsageError(where + "a run without rows");
    Tape7Run run{
        source, {}, {transmissions_.rbegin(), transmissions_.rend()}, {radiances_.rbegin(), radiances_.rend()}};
    for (auto k = wavenumber_.rbegin(); k != wavenumber_.rend(); ++k) run.wavelength_um.push_back(1e4 / *k);
    return run;
  }

 private:
  double number(std::string_view row, const Column& column, const std::string& where, bool blank_is_0) const {
    const std::string_view cell = trimmed_cell(
        column.begin < row.size() ? row.substr(column.begin, column.end - column.begin) : std::string_view{});
    if (cell.empty() && blank_is_0) return 0.0;
    const std::optional<double> value = fortran_number(cell);
    if (!value || !std::isfinite(*value))
      throw UsageError(where + "column " + column.name + " (characters " + std::to_string(column.begin + 1) + " to " +
                       std::to_string(column.end) + ") holds \"" + printable(cell, 40) +
                       "\", no number; was the file edited?");
    return *value;
  }

  std::vector<Column> columns_;
  std::string where_;
  const Column *frequency_ = nullptr, *transmission_ = nullptr, *thermal_ = nullptr, *solar_ = nullptr;
  bool second_header_ = false;
  std::vector<double> wavenumber_, transmissions_, radiances_;
};

}  // namespace

std::vector<Tape7Run> parse_tape7(std::string_view text, const std::string& source) {
  std::vector<Tape7Run> runs;
  std::optional<RunReader> reader;
  std::string header_at;
  std::size_t line = 0;
  while (!text.empty()) {
    ++line;
    const std::string_view row = take_text_line(text);
    const std::string at = source + ":" + std::to_string(line);
    if (row.size() > kLongestLine)
      throw UsageError(at + ": a line of " + std::to_string(row.size()) + " characters; is it a tape7 of MODTRAN?");
    if (!reader) {
      if (row.find("FREQ") == std::string_view::npos) continue;
      reader.emplace(row, at + ": ");
      header_at = at;
    } else if (trimmed_cell(row).starts_with("-9999")) {
      runs.push_back(reader->finish(at + ": ", header_at));
      reader.reset();
    } else {
      reader->add(row, at + ": ");
    }
  }
  if (reader)
    throw UsageError(source + ":" + std::to_string(line) +
                     ": the file is cut short: the run ends without a line -9999.; copy it again");
  if (runs.empty())
    throw UsageError(source + ": no line with FREQ in its " + std::to_string(line) +
                     " lines; is it a tape7 of MODTRAN?");
  return runs;
}

std::vector<Tape7Run> read_tape7(const std::string& path) {
  return parse_tape7(read_table_text(path, kMaxTape7Bytes), path);
}

PathColumns path_columns(const std::vector<Tape7Run>& runs, const std::vector<double>& range_m) {
  if (runs.empty()) throw UsageError("a table of paths: no runs");
  const std::string file = runs.front().source.substr(0, runs.front().source.rfind(':'));
  if (runs.size() != range_m.size())
    throw UsageError(file + ": " + std::to_string(runs.size()) + " runs and " + std::to_string(range_m.size()) +
                     " ranges; give the range of each run");
  PathColumns result{.source = file, .range_m = range_m, .wavelength_um = runs.front().wavelength_um};
  for (std::size_t i = 0; i < runs.size(); ++i) {
    if (!std::isfinite(range_m[i]) || !(range_m[i] > (i == 0 ? 0.0 : range_m[i - 1])))
      throw UsageError(runs[i].source + ": a range of " + format_double(range_m[i]) +
                       " m; ranges have to be above 0 and increase");
    if (runs[i].radiance.empty())
      throw UsageError(runs[i].source +
                       ": a run of transmission alone; a path needs its radiance too: run MODTRAN with IEMSCT 1 or 2");
    if (runs[i].wavelength_um != result.wavelength_um)
      throw UsageError(runs[i].source + ": other wavenumbers than " + runs.front().source + "; give all runs the same");
    result.transmission.push_back(runs[i].transmission);
    result.radiance.push_back(runs[i].radiance);
  }
  return result;
}

}  // namespace mtf::io
