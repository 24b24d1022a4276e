// SPDX-License-Identifier: Apache-2.0
#pragma once

// Values of OTFs over the field and of images by them that were computed elsewhere (data/field of the shared folder).

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "tests/csv_fields.h"

namespace mtf::test {

struct Golden {
  std::string kind, quantity, where, parameters;
  double value = 0.0;
};

inline std::vector<Golden> golden(const std::string& kind) {
  const char* chosen = std::getenv("MTFKIT_SHARED");
  const std::filesystem::path shared = chosen != nullptr
                                           ? std::filesystem::path(chosen)
                                           : std::filesystem::path(__FILE__).parent_path() / "../../../shared";
  std::ifstream file(shared / "data/field/golden_field.csv");
  std::vector<Golden> rows;
  std::string line;
  std::getline(file, line);
  while (std::getline(file, line)) {
    const std::vector<std::string> c = fields_of(line);
    if (c.size() == 6 && c[1] == kind) rows.push_back({c[1], c[2], c[3], c[4], std::stod(c[5])});
  }
  return rows;
}

/// The numbers of "q=(0.8,0.6);nu=(0.1,0)" in their order.
inline std::vector<double> numbers_in(const std::string& text) {
  std::vector<double> numbers;
  for (const char* at = text.c_str(); *at != 0;) {
    char* end = nullptr;
    const double number = std::strtod(at, &end);
    if (end != at) numbers.push_back(number);
    at = end != at ? end : at + 1;
  }
  return numbers;
}

}  // namespace mtf::test
