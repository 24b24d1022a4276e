// SPDX-License-Identifier: Apache-2.0
#include "calib/find/no_data.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <string>

#include "mtf/error.h"
#include "mtf/words.h"

namespace calib {
namespace {

std::string known(std::string_view word, std::span<const std::string_view> names, const char* what) {
  const std::string text = mtf::lower_case(word);
  if (std::find(names.begin(), names.end(), text) != names.end()) return text;
  throw mtf::UsageError("unknown Bayer " + std::string(what) + " \"" + text.substr(0, 40) + "\"; it is one of " +
                        mtf::joined(names));
}

}  // namespace

mtf::Image bayer_plane(mtf::ImageView<const float> image, std::string_view pattern, std::string_view plane) {
  const std::string filters = known(pattern, kBayerPatterns, "pattern"), wanted = known(plane, kBayerPlanes, "plane");
  std::array<bool, 4> keep{};
  for (std::size_t i = 0; i < 4; ++i) {
    const bool red_row = filters[i & 2] == 'r' || filters[(i & 2) + 1] == 'r';
    keep[i] = wanted[0] == filters[i] && (wanted.size() == 1 || (wanted[1] == 'r') == red_row);
  }
  mtf::Image result(image.width, image.height);
  for (std::int64_t y = 0; y < image.height; ++y)
    for (std::int64_t x = 0; x < image.width; ++x)
      result.at(x, y) = keep[static_cast<std::size_t>((y & 1) * 2 + (x & 1))] ? image.at(x, y)
                                                                              : std::numeric_limits<float>::quiet_NaN();
  return result;
}

std::int64_t apply_mask(mtf::ImageView<float> image, mtf::ImageView<const float> mask) {
  const auto size = [](auto view) { return std::to_string(view.width) + " x " + std::to_string(view.height); };
  if (image.width != mask.width || image.height != mask.height)
    throw mtf::UsageError("the mask has " + size(mask) + " pixels, the image " + size(image) +
                          "; a mask has the image's size");
  std::int64_t left = 0;
  for (std::int64_t y = 0; y < image.height; ++y)
    for (std::int64_t x = 0; x < image.width; ++x) {
      const float keep = mask.at(x, y);
      if (keep == 0.0F || std::isnan(keep)) image.at(x, y) = std::numeric_limits<float>::quiet_NaN();
      if (!std::isnan(image.at(x, y))) ++left;
    }
  return left;
}

}  // namespace calib
