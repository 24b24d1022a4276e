// SPDX-License-Identifier: Apache-2.0
#include "tests/fuzz/toml_mutation.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <random>
#include <vector>

namespace fuzz {
namespace {

using Random = std::mt19937;

constexpr std::array<std::string_view, 14> kNumbers = {
    "0",    "-0.0",  "1",   "-1",  "0.5",  "1e-320",     "1e-30",
    "1e30", "1e308", "nan", "inf", "-inf", "2147483648", "9223372036854775807"};
constexpr std::array<std::string_view, 16> kUnits = {"um", "mm", "m",    "km", "urad", "deg",   "px",  "s",
                                                     "Hz", "K",  "degC", "%",  "W/m2", "cy/mm", "um2", ""};
constexpr std::array<std::string_view, 20> kValues = {"true",
                                                      "\"\"",
                                                      "[]",
                                                      "{}",
                                                      "[[1], [2, 3]]",
                                                      "[1, 2, 3]",
                                                      "[\"1 um\", \"2 um\"]",
                                                      "[1e308, 1e308]",
                                                      "[{ r = 1.0 }]",
                                                      "{ r = 0.5 }",
                                                      "{ 1 = 0.3, x = 0.1, y2 = -0.2 }",
                                                      "{ r4 = \"1 um\" }",
                                                      "{ value = 1.0, fit = true }",
                                                      "{ value = \"1 um\", stderr = \"2 um\" }",
                                                      "{ value = 1.0, min = 2.0, max = 1.0, fit = true }",
                                                      "{ value = 0.0, interval = [0.0, 1.0] }",
                                                      "{ table = \"no.csv\" }",
                                                      "2026-11-30T12:00:00Z",
                                                      "\"field\"",
                                                      "\"../../../../dev/zero\""};

template <class List>
auto one_of(const List& list, Random& random) {
  return list[random() % list.size()];
}

std::vector<std::string> lines_of(std::string_view text) {
  std::vector<std::string> lines;
  while (!text.empty()) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    lines.emplace_back(text.substr(0, end));
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return lines;
}

std::string joined(const std::vector<std::string>& lines) {
  std::string text;
  for (const std::string& line : lines) text += line + '\n';
  return text;
}

bool is_header(std::string_view line) { return line.starts_with('['); }

/// A number of the line, which is not part of a word, becomes another.
bool replace_number(std::string& line, std::size_t from, Random& random) {
  const auto digit = [&](std::size_t i) {
    return i < line.size() && std::isdigit(static_cast<unsigned char>(line[i])) != 0;
  };
  std::vector<std::size_t> starts;
  for (std::size_t i = from; i < line.size(); ++i)
    if (digit(i) && !digit(i - 1) && line[i - 1] != '.' && std::isalpha(static_cast<unsigned char>(line[i - 1])) == 0)
      starts.push_back(i);
  if (starts.empty()) return false;
  const std::size_t begin = one_of(starts, random);
  std::size_t end = begin;
  while (digit(end) || (end < line.size() && line[end] == '.')) ++end;
  line.replace(begin, end - begin, one_of(kNumbers, random));
  return true;
}

void replace_value(std::string& line, Random& random) {
  const std::size_t sign = line.find('=');
  if (is_header(line) || sign == std::string::npos) return;
  switch (random() % 4) {
    case 0:
    case 1:
      if (replace_number(line, sign + 1, random)) return;
      break;
    case 2:
      line = line.substr(0, sign + 1) + " \"" + std::string(one_of(kNumbers, random)) + ' ' +
             std::string(one_of(kUnits, random)) + '"';
      return;
    default:
      break;
  }
  line = line.substr(0, sign + 1) + ' ' + std::string(one_of(kValues, random));
}

}  // namespace

std::string mutated_toml(std::string_view text, std::uint32_t seed) {
  Random random(seed);
  std::vector<std::string> lines = lines_of(text);
  if (lines.empty()) return "schema = 2\n";
  const std::size_t at = random() % lines.size(), to = random() % lines.size();
  switch (random() % 8) {
    case 0:
      lines.erase(lines.begin() + static_cast<std::ptrdiff_t>(at));
      break;
    case 1:
      lines.insert(lines.begin() + static_cast<std::ptrdiff_t>(to), std::string(lines[at]));
      break;
    case 2:
      std::swap(lines[at], lines[to]);
      break;
    default:
      replace_value(lines[at], random);
      break;
  }
  return joined(lines);
}

std::string crossed_toml(std::string_view text, std::string_view other, std::uint32_t seed) {
  Random random(seed);
  std::vector<std::string> lines = lines_of(text);
  const std::vector<std::string> others = lines_of(other);
  if (others.empty()) return std::string(text);
  const std::size_t first = random() % others.size();
  const std::size_t count = std::min<std::size_t>(1 + random() % 6, others.size() - first);
  // The table that the lines stand in, if both have it.
  std::size_t header = first;
  while (header > 0 && !is_header(others[header])) --header;
  const auto same = std::find(lines.begin(), lines.end(), others[header]);
  const auto place = same == lines.end() || is_header(others[first]) ? lines.end() : same + 1;
  lines.insert(place, others.begin() + static_cast<std::ptrdiff_t>(first),
               others.begin() + static_cast<std::ptrdiff_t>(first + count));
  return joined(lines);
}

}  // namespace fuzz
