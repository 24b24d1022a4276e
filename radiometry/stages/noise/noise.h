// SPDX-License-Identifier: Apache-2.0
#pragma once

// Noise on frames. A frame is a region of the detector: its first pixel is column x, row y of the whole, and every
// pixel gets the random numbers of its place (random.h), whatever region or number of threads it is worked out with.

#include "mtf/image.h"
#include "radiometry/stages/noise/random.h"

namespace radiometry {

/// Place of a region on the detector, in pixels; 0 <= x, y < 2^32.
struct Origin {
  std::int64_t x = 0;
  std::int64_t y = 0;

  bool operator==(const Origin&) const = default;
};

/// Throws UsageError for a region that does not lie on such a detector.
void require_on_detector(Origin origin, std::int64_t width, std::int64_t height);

/// image += sigma x standard normal numbers. sigma >= 0 and finite; 0 leaves the image as it is, untouched. Of rows,
/// the first and every `every`-th one after it get noise, and the others stay as they are.
/// Throws UsageError for others and for an origin out of its range.
void add_gaussian(mtf::ImageView<float> image, double sigma, const NoiseKey& key, Stream stream, Origin origin = {},
                  int threads = 1, std::int64_t every = 1);

/// Replaces mean electrons by Poisson numbers, exact for any mean (poisson.h); a mean below 0 counts as 0, NaN stays
/// NaN. The numbers rise with the mean where everything else is the same.
void shot_noise(mtf::ImageView<float> image, const NoiseKey& key, Origin origin = {}, int threads = 1,
                std::int64_t every = 1);

/// Standard normal numbers of one row from column x on, for noise of whole rows, columns or frames.
void gaussian_row(const RandomRow& row, std::int64_t x, std::int64_t count, float* out);

}  // namespace radiometry
