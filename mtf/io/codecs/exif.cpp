// SPDX-License-Identifier: Apache-2.0
#include "mtf/io/codecs/exif.h"

#include <algorithm>

namespace mtf::io {

std::optional<std::uint32_t> tag_value(std::span<const unsigned char> tiff, std::uint16_t tag) {
  if (tiff.size() < 8) return std::nullopt;
  const bool little = tiff[0] == 'I';
  const auto number = [&](std::size_t at, std::size_t bytes) {
    std::uint32_t value = 0;
    for (std::size_t i = 0; i < bytes; ++i) value = value << 8U | tiff[at + (little ? bytes - 1 - i : i)];
    return value;
  };
  const std::size_t directory = number(4, 4);
  if (directory > tiff.size() - 2) return std::nullopt;
  constexpr std::size_t row = 12;
  const std::size_t rows = std::min<std::size_t>(number(directory, 2), (tiff.size() - directory - 2) / row);
  for (std::size_t i = 0; i < rows; ++i) {
    const std::size_t at = directory + 2 + i * row;
    constexpr std::uint32_t of_16_bits = 3;
    if (number(at, 2) == tag) return number(at + 8, number(at + 2, 2) == of_16_bits ? 2 : 4);
  }
  return std::nullopt;
}

void note_orientation(std::span<const unsigned char> exif, std::vector<std::string>& notes) {
  constexpr std::uint16_t orientation = 0x0112;
  const std::uint32_t value = tag_value(exif, orientation).value_or(1);
  if (value > 1 && value <= 8)
    notes.push_back("its orientation (Exif " + std::to_string(value) +
                    ") is not applied: rows and columns are those stored");
}

double aspect_of_densities(std::uint32_t x, std::uint32_t y) {
  const std::uint32_t difference = std::max(x, y) - std::min(x, y);
  return x == 0 || y == 0 || (difference == 1 && x > 100) ? 1.0 : static_cast<double>(y) / x;
}

}  // namespace mtf::io
