// SPDX-License-Identifier: Apache-2.0
#include "mtf/components/component_docs.h"

#include <algorithm>
#include <sstream>

namespace mtf {

std::string_view component_notes(std::string_view kind) {
  const auto all = all_component_notes();
  const auto found = std::ranges::find_if(all, [&](const ComponentNotes& notes) { return notes.kind == kind; });
  return found == all.end() ? std::string_view{} : found->text;
}

std::string component_formula(std::string_view kind) {
  std::istringstream lines{std::string(component_notes(kind))};
  const std::string mark = std::string(kind) + ":";
  std::string every, marked;
  for (std::string line; std::getline(lines, line);) {
    if (!line.starts_with("  ")) continue;
    line.erase(0, 2);
    every += line + "\n";
    if (line.starts_with(mark)) marked += line.substr(line.find_first_not_of(' ', mark.size())) + "\n";
  }
  return marked.empty() ? every : marked;
}

std::string component_source(std::string_view kind) {
  std::string text(component_notes(kind));
  if (!text.ends_with(")\n")) return "";
  text.resize(text.size() - 2);
  std::size_t begin = text.size();
  for (int depth = 1; depth > 0 && begin-- > 0;) depth += text[begin] == ')' ? 1 : text[begin] == '(' ? -1 : 0;
  text.erase(0, begin + 1);
  std::replace(text.begin(), text.end(), '\n', ' ');
  return text;
}

}  // namespace mtf
