// SPDX-License-Identifier: Apache-2.0
#include "apps/live/toml_blocks.h"

#include <map>
#include <utility>

namespace apps::live {
namespace {

constexpr std::string_view kOff = "#- ";

struct Line {
  std::size_t begin = 0, end = 0;  ///< with its line break
};

std::vector<Line> lines_of(std::string_view text) {
  std::vector<Line> lines;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find('\n', begin), text.size() - 1) + 1;
    lines.push_back({begin, end});
    begin = end;
  }
  return lines;
}

std::string_view trimmed(std::string_view line) {
  const std::size_t first = line.find_first_not_of(" \t");
  if (first == std::string_view::npos) return {};
  return line.substr(first, line.find_last_not_of(" \t\r\n") - first + 1);
}

/// The name of "[name]" or "[[name]]", maybe with a comment behind it; "" for other lines.
std::pair<std::string, bool> header_of(std::string_view line) {
  line = trimmed(line);
  const bool list = line.starts_with("[[");
  if (!line.starts_with("[")) return {};
  const std::size_t open = list ? 2 : 1, close = line.find(list ? "]]" : "]", open);
  if (close == std::string_view::npos) return {};
  const std::string_view after = trimmed(line.substr(close + open));
  if (!after.empty() && !after.starts_with("#")) return {};
  return {std::string(trimmed(line.substr(open, close - open))), list};
}

/// Whether a line begins or ends a string of several lines: an odd number of its marks.
bool toggles(std::string_view line, std::string_view mark) {
  bool odd = false;
  for (std::size_t at = line.find(mark); at != std::string_view::npos; at = line.find(mark, at + 3)) odd = !odd;
  return odd;
}

}  // namespace

std::vector<TomlBlock> toml_blocks(std::string_view text) {
  std::vector<TomlBlock> blocks;
  std::map<std::pair<std::string, bool>, std::size_t> count;
  const std::vector<Line> lines = lines_of(text);
  bool in_string = false, in_literal = false, off_before = false;
  std::size_t last_content = 0;  // end of the last line that is part of the block at work
  const auto close = [&] {
    if (!blocks.empty() && blocks.back().end == 0) blocks.back().end = last_content;
  };
  for (const Line& at : lines) {
    const std::string_view line = text.substr(at.begin, at.end - at.begin), bare = trimmed(line);
    if (!in_string && !in_literal) {
      const bool off = bare.starts_with(kOff) || bare == trimmed(kOff);  // of a line that was empty
      const auto [name, list] = header_of(bare.starts_with(kOff) ? bare.substr(kOff.size()) : bare);
      // A comment of "#- " lines ends where they end.
      if (!name.empty() || (off_before && !off)) close();
      if (!name.empty()) {
        blocks.push_back({name, list, off, count[{name, off}]++, at.begin, 0});
        last_content = at.end;
      } else if (!bare.empty() && (off || !bare.starts_with("#"))) {
        last_content = at.end;
      }
      off_before = off;
    } else {
      last_content = at.end;
    }
    if (!in_literal && (in_string || !bare.starts_with("#"))) in_string ^= toggles(line, "\"\"\"");
    if (!in_string && (in_literal || !bare.starts_with("#"))) in_literal ^= toggles(line, "'''");
  }
  close();
  return blocks;
}

std::string without_block(std::string_view text, const TomlBlock& block) {
  return std::string(text.substr(0, block.begin)) + std::string(text.substr(block.end));
}

std::string switched_off(std::string_view text, const TomlBlock& block) {
  std::string lines;
  const std::string_view body = text.substr(block.begin, block.end - block.begin);
  for (const Line& line : lines_of(body))
    lines += std::string(kOff) + std::string(body.substr(line.begin, line.end - line.begin));
  return std::string(text.substr(0, block.begin)) + lines + std::string(text.substr(block.end));
}

std::string text_of_off(std::string_view text, const TomlBlock& block) {
  std::string lines;
  const std::string_view body = text.substr(block.begin, block.end - block.begin);
  for (const Line& at : lines_of(body)) {
    const std::string_view line = body.substr(at.begin, at.end - at.begin);
    const std::size_t mark = line.find(kOff);
    lines += mark == std::string_view::npos ? std::string(line) : std::string(line.substr(mark + kOff.size()));
  }
  return lines;
}

std::string switched_on(std::string_view text, const TomlBlock& block) {
  return std::string(text.substr(0, block.begin)) + text_of_off(text, block) + std::string(text.substr(block.end));
}

std::string with_block(std::string_view text, std::string_view block) {
  return std::string(text) + (text.empty() || text.ends_with('\n') ? "" : "\n") + "\n" + std::string(block);
}

}  // namespace apps::live
