// SPDX-License-Identifier: Apache-2.0
#pragma once

// Counts, while a frame goes through the chain, the pixels that are held at an end of the range: those that light has
// brought there, and apart from them the stuck ones, which are defective or blinking.

#include <algorithm>
#include <vector>

#include "mtf/image.h"
#include "radiometry/stages/detector/adc.h"
#include "radiometry/stages/detector/saturation.h"

namespace radiometry {

class HeldCounter {
 public:
  /// Begins a frame of that size, without stuck pixels.
  void begin(const mtf::Image& image) {
    stuck_.clear();
    pixels_ = image.size();
    width_ = image.width();
  }
  /// Marks these pixels as stuck: that an end of the range holds them says nothing of the light.
  template <class Pixels>
  void mark(const Pixels& pixels) {
    for (const auto& pixel : pixels) stuck_.push_back(pixel.y * width_ + pixel.x);
    std::sort(stuck_.begin(), stuck_.end());
    stuck_.erase(std::unique(stuck_.begin(), stuck_.end()), stuck_.end());
  }
  /// Adds the pixels of the frame to those that light may bring to an end, and the stuck ones apart.
  void count(HeldPixels& held, HeldPixels& stuck) const {
    const auto apart = static_cast<std::int64_t>(stuck_.size());
    held.pixels += pixels_ - apart;
    stuck.pixels += apart;
  }

  struct Counts {
    Clipped all, stuck;
    Clipped light() const { return {all.low - stuck.low, all.high - stuck.high}; }
  };
  /// Runs a stage on an image, and first on a copy of the stuck pixels, so that they are counted apart.
  template <class Stage>
  Counts run(mtf::Image& image, const Stage& stage) const {
    Counts counts;
    if (!stuck_.empty()) {
      mtf::Image values(static_cast<std::int64_t>(stuck_.size()), 1);
      std::transform(stuck_.begin(), stuck_.end(), values.data(), [&](std::int64_t i) { return image.data()[i]; });
      counts.stuck = stage(values.view());
    }
    counts.all = stage(image.view());
    return counts;
  }

 private:
  std::vector<std::int64_t> stuck_;  // indices of pixels, rising
  std::int64_t pixels_ = 0, width_ = 0;
};

}  // namespace radiometry
