// SPDX-License-Identifier: Apache-2.0
#include "mtf/io/designs/mtf_listing.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>

#include "mtf/error.h"
#include "mtf/io/csv/csv_cells.h"
#include "mtf/io/csv/csv_numbers.h"
#include "mtf/units.h"
#include "mtf/words.h"

namespace mtf::io {
namespace {

/// CODE V has 0.999 at frequency 0, where every MTF is 1: its values have three digits, cut off.
constexpr double kThreeDigits = 1.5e-3;

/// Places of a name among the words of a header, counted from its end: names of the first column may be of two words.
std::vector<std::size_t> columns_called(const std::vector<std::string>& words, std::string_view name,
                                        std::string_view other) {
  std::vector<std::size_t> places;
  for (std::size_t i = 0; i < words.size(); ++i)
    if (const std::string word = lower_case(words[i]); word == name || word == other)
      places.push_back(words.size() - i);
  return places;
}

struct MtfHeader {
  std::vector<std::size_t> tangential, sagittal;

  explicit MtfHeader(std::string_view line) {
    std::string blanks(line);
    std::ranges::replace(blanks, ',', ' ');
    const std::vector<std::string> words = design_words(blanks);
    tangential = columns_called(words, "tangential", "tan");
    sagittal = columns_called(words, "sagittal", "rad");
  }
  bool is() const { return !tangential.empty() && tangential.size() == sagittal.size(); }
};

/// Of frequencies, as a line says it; "" where it does not.
std::string frequency_unit(std::string_view line) {
  const std::string words = lower_case(line);
  const auto has = [&](std::string_view word) { return words.find(word) != std::string::npos; };
  if (has("cycles per mrad") || has("cycles/mrad") || has("cycles per milliradian") || has("cy/mrad")) return "cy/mrad";
  return has("cycles per mm") || has("cycles/mm") || has("cy/mm") || has("lp/mm") || has("l/mm") ? "cy/mm" : "";
}

/// All frequencies of a file have one unit.
void set_unit(MtfListing& listing, const std::string& unit, const std::string& where) {
  if (!listing.unit.empty() && unit != listing.unit)
    throw UsageError(where + "frequencies in " + (unit.empty() ? "another unit" : unit) + ", and those above in " +
                     listing.unit + "; export all in one unit, or each to a file");
  listing.unit = unit;
}

/// Which pair of columns is that of the nominal focus, by the line of focus positions above the header.
std::size_t nominal_pair(const DesignText& text, std::size_t header, std::size_t pairs, DesignRemarks& remarks) {
  if (pairs == 1) return 0;
  std::vector<double> focus;
  for (const std::string& word : design_words(header > 0 ? text.lines[header - 1] : ""))
    if (const auto value = design_number(word)) focus.push_back(*value);
  const auto nominal = std::ranges::find(focus, 0.0);
  // The pair before those of the focus positions is the diffraction limit.
  if (focus.empty() || focus.size() >= pairs || nominal == focus.end())
    throw UsageError(text.where(header) + "no focus position 0 above the columns (found: " +
                     joined(focus, format_double) + "); compute the MTF at the nominal focus");
  const auto place = static_cast<std::size_t>(nominal - focus.begin());
  if (focus.size() > 1)
    remarks.notes.push_back(text.where(header) + "the nominal focus is taken, position 0 of " +
                            joined(focus, format_double));
  return pairs - focus.size() + place;
}

/// Rows of a listing are `even` steps apart.
void check_mtf(const MtfField& field, bool even, const std::string& where) {
  if (field.frequency.size() < 3) throw UsageError(where + "fewer than three rows of an MTF; export it anew");
  double least = field.frequency[1] - field.frequency[0];
  for (std::size_t i = 1; i < field.frequency.size(); ++i) {
    const double step = field.frequency[i] - field.frequency[i - 1];
    least = std::min(least, step);
    if (step <= 0.0 || (even && step > 1.5 * least))
      throw UsageError(where + "frequency " + format_double(field.frequency[i]) + " follows " +
                       format_double(field.frequency[i - 1]) + ": rows are missing or out of order; export it anew");
  }
}

/// Whether the first line that is no comment names frequencies beside the cuts: a table of places.
bool is_of_places(const DesignText& text) {
  const auto header = std::ranges::find_if_not(text.lines, is_comment);
  if (header == text.lines.end() || !MtfHeader(*header).is()) return false;
  return std::ranges::any_of(design_words(*header), [](const auto& word) { return design_number(word).has_value(); });
}

void read_places(const DesignText& text, const DesignReading& reading, MtfListing& listing) {
  std::array<std::vector<double>, 2> frequencies;  // of the tangential and sagittal columns
  std::array<std::vector<std::size_t>, 2> columns;
  std::string place_unit;
  const std::string remedy = "columns are x (deg), y (deg), tangential (10 cy/mm), sagittal (10 cy/mm), ...";
  const auto choose = [&](const std::vector<std::string_view>& cells, const std::string& where) {
    std::vector<std::size_t> all;
    for (std::size_t i = 0; i < cells.size(); ++i) {
      all.push_back(i);
      const std::vector<std::string> words = design_words(cells[i]);
      const std::string name = words.empty() ? "" : lower_case(words[0]);
      const auto frequency = words.size() > 2 ? design_number(words[1]) : std::nullopt;
      if (i < 2 ? words.size() != 2 || name != (i == 0 ? "x" : "y") : !frequency || frequency_unit(cells[i]).empty())
        throw UsageError(where + "\"" + printable(cells[i], 40) + "\" cannot stand here; " + remedy);
      if (i == 0) place_unit = words[1];
      if (i < 2) continue;
      set_unit(listing, frequency_unit(cells[i]), where);
      frequencies[name.starts_with("tan") ? 0 : 1].push_back(*frequency);
      columns[name.starts_with("tan") ? 0 : 1].push_back(i);
    }
    if (frequencies[0] != frequencies[1])
      throw UsageError(where + "the two cuts are of different frequencies; " + remedy);
    return all;
  };
  const CsvNumbers table = read_csv_numbers(joined(text.lines, "\n"), text.source, remedy, choose);
  for (std::size_t row = 0; row < table.line.size(); ++row) {
    const double y = table.column[1][row];
    MtfField field{DesignField{table.column[0][row], reading.y_up ? 0.0 - y : y, place_unit}, {0.0}, {1.0}, {1.0}};
    field.frequency.insert(field.frequency.end(), frequencies[0].begin(), frequencies[0].end());
    for (const std::size_t i : columns[0]) field.tangential.push_back(table.column[i][row]);
    for (const std::size_t i : columns[1]) field.sagittal.push_back(table.column[i][row]);
    check_mtf(field, false, text.where(table.line[row] - 1));
    listing.fields.push_back(std::move(field));
  }
}

}  // namespace

bool is_mtf_listing(const DesignText& text) {
  return std::ranges::any_of(text.lines, [](const std::string& line) { return MtfHeader(line).is(); });
}

MtfListing read_mtf_listing(const DesignText& text, const DesignReading& reading) {
  MtfListing listing;
  std::optional<DesignField> place;
  bool is_limit = false;
  std::size_t cells = 0;  // of a row
  const bool of_places = is_of_places(text);
  if (of_places) read_places(text, reading, listing);
  for (std::size_t i = 0; i < text.lines.size() && !of_places; ++i) {
    const std::string& line = text.lines[i];
    const std::string words = lower_case(trimmed(line));
    if (const std::string unit = frequency_unit(line); !unit.empty() || words.find("frequency units") < words.size())
      set_unit(listing, unit, text.where(i));
    if (words.starts_with("field")) {
      const std::size_t normalised = line.find("MAX");  // CODE V has the place in parts of the field before it
      place = design_field(normalised == std::string::npos ? line : line.substr(normalised + 3));
      if (place && reading.y_up) place->y = 0.0 - place->y;
      is_limit = words.find("diffraction limit") != std::string::npos;
    }
    if (words.starts_with("relative illumination"))
      listing.remarks.notes.push_back(text.where(i) + printable(trimmed(line), 40) +
                                      ": belongs to [vignetting], not here");
    const MtfHeader header(line);
    if (!header.is()) {
      if (cells > 0 && only_numbers(line, text.decimal_comma).size() == cells)
        throw UsageError(text.where(i) + "a row of an MTF without the names of its columns above; export it anew");
      continue;
    }
    if (listing.unit.empty())
      throw UsageError(text.where(i) + "the unit of the frequencies is missing; a line says cycles per mm, or L/MM");
    const std::size_t pair = nominal_pair(text, i, header.tangential.size(), listing.remarks);
    const std::size_t t = header.tangential[pair], s = header.sagittal[pair];
    MtfField field{.place = place};
    std::size_t end = i + 1;
    for (; end < text.lines.size(); ++end) {
      std::string row_text = text.lines[end];
      if (!text.decimal_comma) std::ranges::replace(row_text, ',', ' ');
      const std::vector<double> row = design_row(row_text, text.where(end));
      if (row.empty()) {  // blanks, rules and comments, as of a new page, end no table
        const std::size_t first = std::min(row_text.find_first_not_of(" \t-=_"), row_text.size());
        const char c = first < row_text.size() ? row_text[first] : '#';
        if (c == '*' || c == '?' || std::isdigit(static_cast<unsigned char>(c)))
          throw UsageError(text.where(end) + "\"" + printable(trimmed(row_text), 40) +
                           "\" is no row of numbers; export the listing anew");
        if (c == '#' || (field.frequency.empty() && !lower_case(trimmed(row_text)).starts_with("field"))) continue;
        break;
      }
      if (field.frequency.empty()) cells = row.size();
      if (row.size() != cells || cells <= std::max({t, s, header.tangential.front()}))
        throw UsageError(text.where(end) + std::to_string(row.size()) +
                         " numbers, and the columns are more; "
                         "export the listing anew");
      field.frequency.push_back(row[0]);
      field.tangential.push_back(row[cells - t]);
      field.sagittal.push_back(row[cells - s]);
    }
    check_mtf(field, true, text.where(i));
    for (std::vector<double>* cut : {&field.tangential, &field.sagittal})
      if (field.frequency[0] == 0.0 && std::abs(cut->front() - 1.0) <= kThreeDigits) cut->front() = 1.0;
    if (!is_limit) listing.fields.push_back(std::move(field));
    i = end - 1;
  }
  if (listing.fields.empty()) throw UsageError(text.source + ": no field but the diffraction limit; list one");
  listing.remarks.warnings.push_back(text.source +
                                     ": an MTF has no phase: what shifts or skews a PSF, such as coma, is left out; "
                                     "import Zernike coefficients or a PSF for that");
  return listing;
}

}  // namespace mtf::io
