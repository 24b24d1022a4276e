// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>

#include "mtf/image.h"

namespace radiometry::test {

inline mtf::Image flat(std::int64_t width, std::int64_t height, float value) {
  mtf::Image image(width, height);
  std::fill_n(image.data(), image.size(), value);
  return image;
}

inline std::span<const float> samples(const mtf::Image& image) {
  return {image.data(), static_cast<std::size_t>(image.size())};
}

}  // namespace radiometry::test
