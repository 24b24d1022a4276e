// SPDX-License-Identifier: Apache-2.0
#pragma once

// Counts, while a frame goes through the chain, which pixels an end of the range holds: those that light has brought
// there, and apart from them those that are meant to be stuck.

#include <algorithm>
#include <vector>

#include "mtf/image.h"
#include "radiometry/stages/detector/adc.h"
#include "radiometry/stages/detector/saturation.h"

namespace radiometry {

class HeldCounter {
 public:
  /// A frame of that size begins, without stuck pixels.
  void begin(const mtf::Image& image) {
    stuck_.clear();
    pixels_ = image.size();
    width_ = image.width();
  }
  /// Pixels with a place: their ends say nothing of the light.
  template <class Pixels>
  void mark(const Pixels& pixels) {
    for (const auto& pixel : pixels) stuck_.push_back(pixel.y * width_ + pixel.x);
  }
  /// All are marked.
  void count(HeldPixels& held, HeldPixels& stuck) {
    std::sort(stuck_.begin(), stuck_.end());
    stuck_.erase(std::unique(stuck_.begin(), stuck_.end()), stuck_.end());
    const auto apart = static_cast<std::int64_t>(stuck_.size());
    held.pixels += pixels_ - apart;
    stuck.pixels += apart;
  }

  struct Counts {
    Clipped all, stuck;
    Clipped light() const { return {all.low - stuck.low, all.high - stuck.high}; }
  };
  /// Runs a stage on an image: first on a copy of the stuck pixels, for its count of them.
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
  std::vector<std::int64_t> stuck_;  // rising
  std::int64_t pixels_ = 0, width_ = 0;
};

}  // namespace radiometry
