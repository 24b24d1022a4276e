// SPDX-License-Identifier: Apache-2.0
#include "radiometry/stages/noise/blinking.h"

#include <cmath>

namespace radiometry {
namespace {

/// Coin and time to the one before it, in dwells: number i of a pixel in a stretch of one dwell.
struct Coin {
  bool high = false;
  double gap = 0.0;
};

Coin coin_of(std::uint64_t seed, std::uint32_t column, std::uint32_t row, std::uint32_t stretch, std::uint32_t i) {
  const std::uint32_t purpose = static_cast<std::uint32_t>(Stream::blinking) + ((i + 1) << 8);
  const Bits128 bits = philox({column, row, stretch, purpose}, seed);
  return {(bits[2] & 1U) != 0, -0.5 * std::log(uniform(bits[0], bits[1]).u)};
}

}  // namespace

std::vector<BlinkingPixel> find_blinking(std::int64_t width, std::int64_t height, const Blinking& blinking,
                                         std::uint64_t seed, Origin origin) {
  require_valid("blinking", blinking);
  require_on_detector(origin, width, height);
  std::vector<BlinkingPixel> found;
  if (blinking.fraction == 0.0) return found;
  for (std::int64_t y = 0; y < height; ++y) {
    const RandomRow random{{seed, 0}, Stream::blinking, static_cast<std::uint32_t>(origin.y + y)};
    for (std::int64_t x = 0; x < width; ++x) {
      // Below the fraction it blinks; the place in there gives the excess by inversion.
      const double u = uniform_at(random, static_cast<std::uint64_t>(origin.x + x)).u;
      if (u < blinking.fraction)
        found.push_back({x, y, static_cast<float>(-blinking.excess_e * std::log(u / blinking.fraction))});
    }
  }
  return found;
}

bool is_high(const Blinking& blinking, const NoiseKey& key, std::int64_t column, std::int64_t row) {
  // Coins of each stretch of a dwell are drawn from its end backwards, 2 on average. Time before frame 0 is one stretch
  // more, with a number of its own, and whatever lies before that is a coin by itself.
  const double now = static_cast<double>(key.frame) / blinking.dwell_frames;
  const auto x = static_cast<std::uint32_t>(column), y = static_cast<std::uint32_t>(row);
  auto stretch = static_cast<std::int64_t>(std::floor(now));
  for (; stretch >= 0; --stretch) {
    double time = static_cast<double>(stretch) + 1.0;
    for (std::uint32_t i = 0; i < 1000; ++i) {
      const Coin coin = coin_of(key.seed, x, y, static_cast<std::uint32_t>(stretch), i);
      time -= coin.gap;
      if (time < static_cast<double>(stretch)) break;
      if (time <= now) return coin.high;
    }
  }
  return coin_of(key.seed, x, y, 0xffffffffU, 0).high;
}

std::vector<BlinkingPixel> apply_blinking(mtf::ImageView<float> image, std::span<const BlinkingPixel> pixels,
                                          const Blinking& blinking, const NoiseKey& key, Origin origin) {
  require_valid("blinking", blinking);
  require_on_detector(origin, image.width, image.height);
  std::vector<BlinkingPixel> high;
  for (const BlinkingPixel& pixel : pixels) {
    if (pixel.x < 0 || pixel.y < 0 || pixel.x >= image.width || pixel.y >= image.height)
      throw mtf::UsageError("blinking: pixel " + std::to_string(pixel.x) + ", " + std::to_string(pixel.y) +
                            " is outside an image of " + size_of(image.width, image.height));
    if (!is_high(blinking, key, origin.x + pixel.x, origin.y + pixel.y)) continue;
    image.at(pixel.x, pixel.y) += pixel.excess_e;
    high.push_back(pixel);
  }
  return high;
}

}  // namespace radiometry
