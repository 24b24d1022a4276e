// SPDX-License-Identifier: Apache-2.0
#include "calib/find/mask.h"

#include <cmath>
#include <limits>
#include <string>

#include "mtf/error.h"

namespace calib {

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
