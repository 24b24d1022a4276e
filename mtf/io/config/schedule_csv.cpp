// SPDX-License-Identifier: Apache-2.0
#include "mtf/io/config/schedule_csv.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <optional>

#include "mtf/words.h"

namespace mtf::io {
namespace {

constexpr int kMaxLines = 1'000'000;
constexpr std::size_t kMaxCell = 4096;
constexpr std::string_view kHeader = "the first line has to be frame,parameter,value";
constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";

std::string_view trimmed(std::string_view text) {
  constexpr std::string_view blanks = " \t";
  const std::size_t begin = text.find_first_not_of(blanks);
  return begin == std::string_view::npos ? std::string_view{}
                                         : text.substr(begin, text.find_last_not_of(blanks) - begin + 1);
}

bool is_text(std::string_view line) {
  return std::all_of(line.begin(), line.end(),
                     [](char c) { return c == '\t' || (static_cast<unsigned char>(c) >= 0x20 && c != 0x7f); });
}

/// The next line without its end (LF, CRLF or CR), taken off `rest`.
std::string_view take_line(std::string_view& rest) {
  const std::size_t end = std::min(rest.find_first_of("\r\n"), rest.size());
  const std::string_view line = rest.substr(0, end);
  rest.remove_prefix(end);
  rest.remove_prefix(rest.starts_with("\r\n") ? 2 : rest.empty() ? 0 : 1);
  return line;
}

/// Cells of a line; a cell in double quotes may hold the separator, and a quote as two. Nothing when a quote is open.
std::optional<std::vector<std::string>> cells_of(std::string_view line, char separator) {
  std::vector<std::string> cells;
  for (;;) {
    const std::size_t begin = std::min(line.find_first_not_of(separator == '\t' ? " " : " \t"), line.size());
    std::string cell;
    if (begin < line.size() && line[begin] == '"') {
      std::size_t at = begin + 1;
      for (;; ++at) {
        if (at >= line.size()) return std::nullopt;
        if (line[at] != '"')
          cell += line[at];
        else if (at + 1 < line.size() && line[at + 1] == '"')
          cell += line[at++];
        else
          break;
      }
      line.remove_prefix(at + 1);
      const std::size_t end = std::min(line.find(separator), line.size());
      if (!trimmed(line.substr(0, end)).empty()) return std::nullopt;
      line.remove_prefix(end);
    } else {
      const std::size_t end = std::min(line.find(separator), line.size());
      cell = trimmed(line.substr(0, end));
      line.remove_prefix(end);
    }
    cells.push_back(std::move(cell));
    if (line.empty()) return cells;
    line.remove_prefix(1);
  }
}

struct ScheduleColumns {
  char separator = ',';
  std::array<std::size_t, 3> at{};  ///< of frame, parameter, value
};

/// What is wrong with the header, "" when it is good.
std::string read_header(std::string_view line, ScheduleColumns& columns) {
  constexpr std::array<std::string_view, 3> names{"frame", "parameter", "value"};
  for (const char c : {';', '\t'})
    if (line.find(c) != std::string_view::npos) columns.separator = c;
  const auto cells = cells_of(line, columns.separator);
  const std::string found = "; found: " + printable(line, 60);
  if (!cells || cells->size() != names.size()) return std::string(kHeader) + found;
  for (std::size_t i = 0; i < names.size(); ++i) {
    const auto cell = std::find(cells->begin(), cells->end(), names[i]);
    if (cell == cells->end()) return std::string(kHeader) + found;
    columns.at[i] = static_cast<std::size_t>(cell - cells->begin());
  }
  return "";
}

/// What is wrong with a line, "" when it is good.
std::string read_line(std::string_view line, const ScheduleColumns& columns, Setting& setting) {
  const auto cells = cells_of(line, columns.separator);
  if (!cells) return "a quote is open, or text follows a closed one: " + printable(line, 60);
  if (cells->size() != 3)
    return std::to_string(cells->size()) + " values where 3 belong (frame, parameter, value)" +
           (cells->size() > 3 ? "; put a value that holds the separator in double quotes" : "");
  const std::string& number = (*cells)[columns.at[0]];
  const auto [end, status] = std::from_chars(number.data(), number.data() + number.size(), setting.frame);
  if (status != std::errc{} || end != number.data() + number.size() || setting.frame < 0 || setting.frame > kLastFrame)
    return "'" + printable(number, 40) + "' is no frame; write a whole number from 0 to " + std::to_string(kLastFrame);
  setting.parameter = (*cells)[columns.at[1]];
  setting.value = (*cells)[columns.at[2]];
  if (setting.parameter.empty()) return "no parameter is named";
  if (setting.value.empty()) return setting.parameter.substr(0, 80) + " is given no value";
  if (setting.parameter.size() > kMaxCell || setting.value.size() > kMaxCell)
    return "a name or value of more than " + std::to_string(kMaxCell) + " characters";
  return "";
}

}  // namespace

std::string schedule_error(const std::string& file, int line, const std::string& text) {
  return file + ":" + std::to_string(line) + ": error: " + text;
}

std::vector<Setting> read_settings(std::string_view text, const std::string& file, std::vector<std::string>& errors) {
  std::vector<Setting> settings;
  const auto fail = [&](int line, const std::string& what) { errors.push_back(schedule_error(file, line, what)); };
  if (text.starts_with(kByteOrderMark)) text.remove_prefix(kByteOrderMark.size());
  ScheduleColumns columns;
  bool header = false;
  for (int number = 1; !text.empty() && errors.size() < kMostScheduleErrors; ++number) {
    const std::string_view line = take_line(text);
    if (number > kMaxLines) return fail(number, "more than " + std::to_string(kMaxLines) + " lines"), settings;
    if (!is_text(line)) return fail(number, "no text; " + std::string(kHeader)), settings;
    if (trimmed(line).empty() || trimmed(line).starts_with('#')) continue;
    if (!header) {
      if (const std::string wrong = read_header(line, columns); !wrong.empty()) return fail(number, wrong), settings;
      header = true;
      continue;
    }
    Setting setting{.frame = 0, .parameter = {}, .value = {}, .line = number};
    if (const std::string wrong = read_line(line, columns, setting); wrong.empty())
      settings.push_back(std::move(setting));
    else
      fail(number, wrong);
  }
  if (!header) fail(1, "nothing is in it; " + std::string(kHeader));
  if (header && settings.empty() && errors.empty())
    fail(1, "no line sets a parameter; add one such as 10,jitter.rms,8 urad");
  return settings;
}

}  // namespace mtf::io
