// SPDX-License-Identifier: Apache-2.0
#include "mtf/io/designs/design_columns.h"

#include <algorithm>
#include <cmath>

#include "mtf/error.h"
#include "mtf/io/csv/csv_cells.h"
#include "mtf/units.h"
#include "mtf/words.h"

namespace mtf::io {
namespace {

constexpr std::size_t kMostColumns = 1000;

/// Z1 (waves) ... Z8 (waves) of "Z1-Z8 (waves)"; the name itself where it is no range of terms.
std::vector<std::string> named(std::string_view word) {
  const std::size_t blank = std::min(word.find(' '), word.size());
  const auto ends = split_words(word.substr(0, blank), "Z-");
  if (!word.starts_with('Z') || ends.size() != 2) return {std::string(word)};
  const int first = cell_number<int>(ends[0]).value_or(0), last = cell_number<int>(ends[1]).value_or(0);
  if (first < 1 || last < first || last > 1000)
    throw UsageError("--columns: \"" + printable(word, 40) + "\" is no range of terms; write it like Z1-Z8 (waves)");
  std::vector<std::string> names;
  for (int term = first; term <= last; ++term)
    names.push_back("Z" + std::to_string(term) + std::string(word.substr(blank)));
  return names;
}

}  // namespace

std::string field_scan_columns(const DesignText& text) {
  if (!text.has("Zernike")) return "";
  std::string unit, wavelength;
  for (std::size_t i = 0; i < text.lines.size(); ++i) {
    const std::string line = lower_case(trimmed(text.lines[i]));
    const std::vector<std::string> words = design_words(line);
    const auto is_term = [](const std::string& word) { return cell_number<int>(word).has_value(); };
    if (words.size() > 1 && line.starts_with("field:") && std::all_of(words.begin() + 1, words.end(), is_term)) {
      if (unit.empty() || wavelength.empty())
        throw UsageError(
            text.where(i) + "the unit of the fields or the wavelength is not stated above; name the columns: " +
            "--columns \"x (deg) = 0, y (deg), wavelength (um) = 0.55, Z1-Z" + words.back() + " (waves)\"");
      return "x (" + unit + ") = 0, y (" + unit + "), wavelength (um) = " + wavelength + ", " +
             joined(std::span(words).subspan(1), [](const auto& term) { return "Z" + term + " (waves)"; });
    }
    for (const std::string& word : words)
      if (line.find("field") != std::string::npos && (word.starts_with("deg") || word.starts_with("millim")))
        unit = word.starts_with("deg") ? "deg" : "mm";
    if (const auto um = design_length_um(line); um && line.starts_with("wavelength")) wavelength = format_double(*um);
  }
  return "";
}

DesignText with_columns(const DesignText& text, const std::string& columns, DesignRemarks& remarks) {
  struct Slot {
    std::string name;
    std::optional<double> constant{};
  };
  std::vector<Slot> slots;
  for (const std::string_view item : split_cells(columns, ',', kMostColumns)) {
    const std::size_t equals = item.find('=');
    std::optional<double> constant;
    if (equals != std::string_view::npos) constant = design_number(trimmed(item.substr(equals + 1)));
    if (equals != std::string_view::npos && (!constant || !std::isfinite(*constant)))
      throw UsageError("--columns: \"" + printable(item, 40) + "\" needs a number, as in wavelength (um) = 0.55");
    for (std::string& name : named(trimmed(item.substr(0, equals)))) slots.push_back({std::move(name), constant});
  }
  // Of a row.
  const auto numbers =
      static_cast<std::size_t>(std::ranges::count_if(slots, [](const Slot& slot) { return !slot.constant; }));
  DesignText table{.source = text.source,
                   .encoding = text.encoding,
                   .lines = {},
                   .decimal_comma = text.decimal_comma,
                   .order = text.order};
  std::size_t rows = 0, first = 0;
  std::vector<std::string> left_out;
  for (std::size_t i = 0; i < text.lines.size(); ++i) {
    const std::vector<double> row = only_numbers(text.lines[i], text.decimal_comma);
    std::string& line = table.lines.emplace_back("#");
    if (row.size() == numbers) {
      if (rows++ == 0) first = i;
      line.clear();
      auto number = row.begin();
      for (const Slot& slot : slots) {
        const double value = slot.constant ? *slot.constant : *number++;
        if (slot.name != "-") append_word(line, number_text(value), ';');
      }
    } else if (const auto words = design_words(text.lines[i]);
               !words.empty() &&
               words[0].find_first_of("0123456789*") == std::min(words[0].find_first_not_of("+-.,"), words[0].size())) {
      left_out.push_back(std::to_string(i + 1));
    }
  }
  if (rows == 0)
    throw UsageError(text.source + ": no line has the " + plural(static_cast<std::int64_t>(numbers), "number") +
                     " that --columns names; name all of a line, - for those that are left out" +
                     (text.decimal_comma ? " (a comma is the decimal point here)" : ""));
  std::string header;
  for (const Slot& slot : slots)
    if (slot.name != "-") append_word(header, slot.name, ';');
  if (first > 0)
    table.lines[first - 1] = header;
  else
    table.lines.insert(table.lines.begin(), header), table.first_line = 0;
  remarks.notes.push_back(
      text.source + ": " + plural(static_cast<std::int64_t>(rows), "row") + " of the columns " + columns +
      (left_out.empty() ? "" : "; lines of other numbers, left out: " + printable(joined(left_out), 60)));
  return table;
}

}  // namespace mtf::io
