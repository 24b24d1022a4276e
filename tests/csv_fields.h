// SPDX-License-Identifier: Apache-2.0
#pragma once

// A line of CSV, for tests of every library: as gtest's own macros it stands in no namespace.

#include <string>
#include <vector>

/// Fields are quoted where they hold a comma; none holds a quote.
inline std::vector<std::string> fields_of(const std::string& line) {
  std::vector<std::string> fields{""};
  bool quoted = false;
  for (const char c : line) {
    if (c == '"')
      quoted = !quoted;
    else if (c == ',' && !quoted)
      fields.emplace_back();
    else
      fields.back() += c;
  }
  return fields;
}
