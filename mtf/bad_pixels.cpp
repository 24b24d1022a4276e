// SPDX-License-Identifier: Apache-2.0
#include "mtf/bad_pixels.h"

#include <cmath>
#include <limits>
#include <vector>

#include "mtf/error.h"

namespace mtf {
namespace {

// Sum and number of the finite pixels below each cell of one level.
struct Level {
  std::int64_t width = 0, height = 0;
  std::vector<double> sum, count;
  std::size_t index(std::int64_t x, std::int64_t y) const { return static_cast<std::size_t>(y * width + x); }
};

Level halve(const Level& fine) {
  Level coarse{(fine.width + 1) / 2, (fine.height + 1) / 2, {}, {}};
  coarse.sum.assign(static_cast<std::size_t>(coarse.width * coarse.height), 0.0);
  coarse.count = coarse.sum;
  for (std::int64_t y = 0; y < fine.height; ++y)
    for (std::int64_t x = 0; x < fine.width; ++x) {
      coarse.sum[coarse.index(x / 2, y / 2)] += fine.sum[fine.index(x, y)];
      coarse.count[coarse.index(x / 2, y / 2)] += fine.count[fine.index(x, y)];
    }
  return coarse;
}

Level first_level(ImageView<float> image) {
  Level level{(image.width + 1) / 2, (image.height + 1) / 2, {}, {}};
  level.sum.assign(static_cast<std::size_t>(level.width * level.height), 0.0);
  level.count = level.sum;
  for (std::int64_t y = 0; y < image.height; ++y)
    for (std::int64_t x = 0; x < image.width; ++x)
      if (const double v = image.at(x, y); std::isfinite(v)) {
        level.sum[level.index(x / 2, y / 2)] += v;
        level.count[level.index(x / 2, y / 2)] += 1.0;
      }
  return level;
}

}  // namespace

std::int64_t fill_bad_pixels(ImageView<float> image) {
  std::vector<Level> levels;
  std::int64_t replaced = 0;
  for (std::int64_t y = 0; y < image.height; ++y)
    for (std::int64_t x = 0; x < image.width; ++x) {
      if (std::isfinite(image.at(x, y))) continue;
      if (levels.empty()) {
        levels.push_back(first_level(image));
        while (levels.back().width > 1 || levels.back().height > 1) levels.push_back(halve(levels.back()));
        if (levels.back().count.front() == 0.0) throw RuntimeError("no pixel is finite; nothing to fill from");
      }
      std::int64_t cx = x / 2, cy = y / 2;
      std::size_t l = 0;
      for (; levels[l].count[levels[l].index(cx, cy)] == 0.0; ++l) cx /= 2, cy /= 2;
      image.at(x, y) =
          static_cast<float>(levels[l].sum[levels[l].index(cx, cy)] / levels[l].count[levels[l].index(cx, cy)]);
      ++replaced;
    }
  return replaced;
}

Image bad_pixel_mask(ImageView<const float> image) {
  Image mask(image.width, image.height);
  bool any = false;
  for (std::int64_t y = 0; y < image.height; ++y)
    for (std::int64_t x = 0; x < image.width; ++x) {
      const bool bad = !std::isfinite(image.at(x, y));
      mask.at(x, y) = bad ? 1.0F : 0.0F;
      any = any || bad;
    }
  return any ? std::move(mask) : Image();
}

void spoil(ImageView<float> image, ImageView<const float> share, double tolerance) {
  for (std::int64_t y = 0; y < image.height; ++y)
    for (std::int64_t x = 0; x < image.width; ++x)
      if (std::abs(static_cast<double>(share.at(x, y))) > tolerance)
        image.at(x, y) = std::numeric_limits<float>::quiet_NaN();
}

}  // namespace mtf
