// SPDX-License-Identifier: Apache-2.0
#include "apps/text/words.h"

#include <array>
#include <cstdio>
#include <limits>

#include "mtf/io/file_checks.h"

namespace apps {
namespace {

std::string formatted(const char* format, int digits, double value) {
  std::array<char, 400> text{};
  static_cast<void>(std::snprintf(text.data(), text.size(), format, digits, value));
  return text.data();
}

}  // namespace

std::string one_line(std::string_view text) {
  return mtf::io::printable(text, std::numeric_limits<std::size_t>::max());
}

std::string joined(const std::vector<std::string>& parts, std::string_view between) {
  std::string text;
  for (const std::string& part : parts) text += (text.empty() ? "" : std::string(between)) + part;
  return text;
}

std::string plural(std::int64_t count, const std::string& word) {
  return std::to_string(count) + " " + word + (count == 1 ? "" : "s");
}

std::string fixed(double value, int decimals) { return formatted("%.*f", decimals, value); }

std::string significant(double value, int digits, bool zeros) {
  return formatted(zeros ? "%#.*g" : "%.*g", digits, value);
}

}  // namespace apps
