// SPDX-License-Identifier: Apache-2.0
#pragma once

// Blinking pixels: random telegraph signals. A pixel is low or high; high, it has an excess of electrons of its own,
// exponentially distributed over the pixels. The times in either state are exponentially distributed with one mean, the
// dwell. So the chance of a change from one frame to the next is (1 - exp(-2/d))/2, the covariance of two frames n
// apart excess^2/4 exp(-2 n/d), for a dwell of d frames. (Machlup, J. Appl. Phys. 25, 341 (1954).)
// The same process: at times 2/d to a frame, a Poisson process, a fair coin says the state from then on. The coins and
// times of d frames each are random numbers by counter, so that the state in a frame follows from the last one before
// it, without the frames in between.

#include <span>
#include <vector>

#include "mtf/image.h"
#include "radiometry/fields.h"
#include "radiometry/stages/noise/noise.h"

namespace radiometry {

struct Blinking {
  double fraction = 0.0;
  double excess_e = 0.0;
  double dwell_frames = 100.0;

  static constexpr auto fields() {
    return std::tuple{required(&Blinking::fraction, "fraction", 0.0, 1.0, "0.001", "part of the pixels that blink"),
                      required(&Blinking::excess_e, "excess", "e-", 0.0, 1e30, "\"2000 e-\"",
                               "mean over the blinking pixels of the excess in the high state"),
                      optional(&Blinking::dwell_frames, "dwell", 1.0, 1e9, "250", "mean time in a state, in frames")};
  }

  bool operator==(const Blinking&) const = default;
};

struct BlinkingPixel {
  std::int64_t x = 0, y = 0;  ///< in the region
  float excess_e = 0.0F;      ///< when high
};

/// The blinking pixels of a region, row by row: found once for a sequence, the same for any region. Throws UsageError
/// for values out of their bounds.
std::vector<BlinkingPixel> find_blinking(std::int64_t width, std::int64_t height, const Blinking& blinking,
                                         std::uint64_t seed, Origin origin = {});

/// Whether the pixel at a place of the detector is high in a frame.
bool is_high(const Blinking& blinking, const NoiseKey& key, std::int64_t column, std::int64_t row);

/// Adds the excess of those that are high to mean electrons and returns these. `origin` is that of the region they were
/// found in. UsageError for a pixel outside the image.
std::vector<BlinkingPixel> apply_blinking(mtf::ImageView<float> image, std::span<const BlinkingPixel> pixels,
                                          const Blinking& blinking, const NoiseKey& key, Origin origin = {});

}  // namespace radiometry
