// SPDX-License-Identifier: Apache-2.0
#pragma once

// The small parts of every text table: lines, cells, numbers. Header only, so that a reader outside mtf/io needs no
// library for it.

#include <algorithm>
#include <array>
#include <charconv>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace mtf::io {

/// Tables with more rows or columns than these are refused.
inline constexpr std::size_t kMaxTableRows = 1'000'000, kMaxTableColumns = 64;

/// Without blanks at the ends and one pair of double quotes around the rest.
inline std::string_view trimmed_cell(std::string_view text) {
  constexpr std::string_view blanks = " \t\r";
  const std::size_t begin = text.find_first_not_of(blanks);
  if (begin == std::string_view::npos) return {};
  text = text.substr(begin, text.find_last_not_of(blanks) - begin + 1);
  if (text.size() >= 2 && text.front() == '"' && text.back() == '"') text = text.substr(1, text.size() - 2);
  return text;
}

/// Trimmed cells of a line, at most `limit` + 1 of them.
inline std::vector<std::string_view> split_cells(std::string_view line, char separator,
                                                 std::size_t limit = kMaxTableColumns) {
  std::vector<std::string_view> cells;
  for (std::size_t at = 0; cells.size() <= limit;) {
    const std::size_t end = line.find(separator, at);
    cells.push_back(trimmed_cell(line.substr(at, end - at)));
    if (end == std::string_view::npos) break;
    at = end + 1;
  }
  return cells;
}

/// Words of a line, between any number of these.
inline std::vector<std::string_view> split_words(std::string_view line, std::string_view between = " \t\r") {
  std::vector<std::string_view> words;
  for (std::size_t at = line.find_first_not_of(between); at != std::string_view::npos;) {
    const std::size_t end = std::min(line.find_first_of(between, at), line.size());
    words.push_back(line.substr(at, end - at));
    at = line.find_first_not_of(between, end);
  }
  return words;
}

/// Text as a cell that is written, in quotes where it has to be.
inline std::string csv_field(std::string_view text) {
  if (text.find_first_of(",\"\r\n") == std::string_view::npos) return std::string(text);
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
  return quoted + "\"";
}

/// A tab or semicolon where the line has one, else a comma.
inline char separator_of(std::string_view line) {
  char separator = ',';
  for (const char c : {';', '\t'})
    if (line.find(c) != std::string_view::npos) separator = c;
  return separator;
}

/// The whole cell as a number, whatever the locale.
template <class T = double>
std::optional<T> cell_number(std::string_view cell) {
  if (cell.starts_with('+') && !cell.starts_with("+-")) cell.remove_prefix(1);
  T value{};
  const auto [end, status] = std::from_chars(cell.data(), cell.data() + cell.size(), value);
  if (status != std::errc{} || end != cell.data() + cell.size()) return std::nullopt;
  return value;
}

/// Takes the next line, without its end, off `text`.
inline std::string_view take_text_line(std::string_view& text) {
  const std::size_t end = std::min(text.find('\n'), text.size());
  const std::string_view line = text.substr(0, end);
  text.remove_prefix(std::min(end + 1, text.size()));
  return line;
}

/// Without the byte order mark that some editors write.
inline std::string_view without_mark(std::string_view text) {
  if (text.starts_with("\xEF\xBB\xBF")) text.remove_prefix(3);
  return text;
}

/// True for lines without content: empty, or comments, which start with #.
inline bool is_comment(std::string_view line) {
  const std::string_view cell = trimmed_cell(line);
  return cell.empty() || cell.starts_with('#');
}

/// The shortest text that reads back as the same number, whatever the locale.
template <class T>
std::string number_text(T value) {
  std::array<char, 64> text{};
  return {text.data(), std::to_chars(text.data(), text.data() + text.size(), value).ptr};
}

/// Appends `word`, with `separator` before it unless the text is empty.
inline void append_word(std::string& text, std::string_view word, char separator = ' ') {
  if (!text.empty()) text += separator;
  text += word;
}

}  // namespace mtf::io
