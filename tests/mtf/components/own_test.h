// SPDX-License-Identifier: Apache-2.0
#pragma once

// Which kinds of component have a test file of their own.

#include <fstream>
#include <iterator>
#include <string>
#include <string_view>

namespace mtf::test {

/// tests/mtf/components/test_KIND.cpp exists and makes that kind. Such a file carries the reference values of a kind
/// that the tables of notebooks-data/reference leave out.
inline bool has_own_test(std::string_view kind) {
  const std::string name(kind);
  std::ifstream file(MTFKIT_SOURCE_DIR "/tests/mtf/components/test_" + name + ".cpp");
  const std::string text{std::istreambuf_iterator<char>(file), {}};
  return text.find("make(\"" + name + "\")") != std::string::npos;
}

}  // namespace mtf::test
