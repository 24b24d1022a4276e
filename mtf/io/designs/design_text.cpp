// SPDX-License-Identifier: Apache-2.0
#include "mtf/io/designs/design_text.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>

#include "mtf/error.h"
#include "mtf/io/csv/csv_cells.h"
#include "mtf/io/csv/curve_csv.h"
#include "mtf/units.h"
#include "mtf/words.h"

namespace mtf::io {
namespace {

constexpr std::size_t kMostDesignBytes = std::size_t{64} << 20;

constexpr std::string_view kMicro = "\xC2\xB5";  // in Latin-1 its second byte alone

/// By its mark; else text of Latin letters has a zero in nearly every pair, always on the same side.
bool is_utf16(std::string_view bytes) {
  if (bytes.starts_with("\xFF\xFE") || bytes.starts_with("\xFE\xFF")) return true;
  std::array<std::size_t, 2> zeros{};
  const std::size_t count = std::min<std::size_t>(bytes.size(), 1024);
  for (std::size_t i = 0; i < count; ++i) zeros[i % 2] += bytes[i] == '\0' ? 1U : 0U;
  return count > 0 && std::min(zeros[0], zeros[1]) == 0 && 20 * std::max(zeros[0], zeros[1]) >= 9 * count;
}

/// In either byte order what is left without zeros is Latin-1, but for names in other letters.
std::string from_utf16(std::string_view bytes) {
  std::string text(bytes.starts_with('\xFF') || bytes.starts_with('\xFE') ? bytes.substr(2) : bytes);
  std::erase(text, '\0');
  std::ranges::replace_if(
      text, [](unsigned char c) { return c < 32 && !std::isspace(c); }, '?');
  return text;
}

}  // namespace

std::size_t DesignText::find(std::string_view words, std::size_t from) const {
  const std::string wanted = lower_case(words);
  while (from < lines.size() && lower_case(lines[from]).find(wanted) == std::string::npos) ++from;
  return from;
}

DesignText design_text(std::string_view bytes, const std::string& source) {
  DesignText design{.source = source, .encoding = "UTF-8", .lines = {}};
  const bool utf16 = is_utf16(bytes);
  std::string text = utf16 ? from_utf16(bytes) : std::string(without_mark(bytes));
  if (std::ranges::any_of(text, [](unsigned char c) { return c < 32 && !std::isspace(c); }))
    throw UsageError(source + ": binary or encrypted; in the lens program show the text of the analysis and save that");
  std::erase(text, '\r');
  for (std::size_t at = 0; (at = text.find(kMicro[1], at)) != std::string::npos; at += 2) {
    if (at > 0 && text[at - 1] == kMicro[0]) continue;
    text.insert(at, 1, kMicro[0]);
    design.encoding = "Latin-1";
  }
  if (utf16) design.encoding = "UTF-16";
  for (std::string_view rest = text; !rest.empty();) design.lines.emplace_back(take_text_line(rest));
  for (const std::string& line : design.lines)
    for (const std::string& word : design_words(line))
      design.decimal_comma = design.decimal_comma || (design_number(word) && word.find(',') != std::string::npos);
  return design;
}

DesignText read_design_text(const std::string& path) {
  return design_text(read_text_file(path, kMostDesignBytes), path);
}

std::vector<std::string> design_words(std::string_view line) {
  std::vector<std::string> words;
  for (std::string_view word : split_words(line, " \t()[]:=|;")) {
    while (word.ends_with(',') || word.ends_with('.')) word.remove_suffix(1);
    if (!word.empty()) words.emplace_back(word);
  }
  return words;
}

std::optional<double> design_number(std::string_view word) {
  std::string text(word);
  if (text.find('.') == std::string::npos) std::ranges::replace(text, ',', '.');
  return cell_number(text);
}

std::vector<double> design_row(std::string_view line, const std::string& where) {
  std::vector<double> row;
  for (const std::string& word : design_words(line)) {
    const std::optional<double> value = design_number(word);
    if (row.empty() && !value) return {};
    if (!value || !std::isfinite(*value))
      throw UsageError(where + "\"" + printable(word, 40) + "\" is no finite number; export the listing anew");
    row.push_back(*value);
  }
  return row;
}

std::vector<double> only_numbers(std::string line, bool decimal_comma) {
  std::vector<double> row;
  if (!decimal_comma) std::ranges::replace(line, ',', ' ');
  for (const std::string& word : design_words(line)) {
    const std::optional<double> value = design_number(word);
    if (!value || !std::isfinite(*value)) return {};
    row.push_back(*value);
  }
  return row;
}

std::optional<double> design_length_um(std::string_view line) {
  const std::vector<std::string> words = design_words(line);
  for (std::size_t i = 0; i + 1 < words.size(); ++i) {
    const auto value = design_number(words[i]);
    const Unit* unit = find_unit(words[i + 1]);
    if (value && unit != nullptr && unit->dimension == Dimension::length) return convert({*value, unit}, "um");
  }
  return std::nullopt;
}

std::string DesignField::text() const { return "(" + format_double(x) + ", " + format_double(y) + ") " + unit; }

std::optional<DesignField> design_field(std::string_view line) {
  std::vector<double> numbers;
  for (const std::string& word : design_words(line)) {
    if (const auto value = design_number(word)) {
      numbers.push_back(*value);
    } else if (!numbers.empty()) {
      const std::string unit = lower_case(word);
      if (numbers.size() > 2 || !std::isfinite(numbers.front() + numbers.back())) return std::nullopt;
      return DesignField{.x = numbers.size() == 1 ? 0.0 : numbers[0],
                         .y = numbers.back(),
                         .unit = unit == "millimeters" ? "mm" : unit};
    }
  }
  return std::nullopt;
}

}  // namespace mtf::io
