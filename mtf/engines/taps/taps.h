// SPDX-License-Identifier: Apache-2.0
#pragma once

// Filtering in the space domain, for point spreads of a few samples: detector sample j along an axis is a weighted sum
// of the scene samples j x ratio + first + t, t = 0 .. count - 1, whole ratios only. Both engines walk over tiles of
// the output that fit the cache; a group of 16 outputs of a row is H(0) times one value where all
// samples that the taps read for them have this value. Taps that equal their mirror image bit by bit let mirrored
// samples be added before they are multiplied.

#include <memory>
#include <vector>

#include "mtf/border.h"
#include "mtf/engines/engine.h"

namespace mtf {

struct TapAxis {
  std::int64_t samples = 0;  ///< of the scene
  std::int64_t outputs = 0;  ///< detector samples, from the shared corner
  std::int64_t ratio = 1;    ///< scene samples a detector sample
  std::int64_t first = 0;    ///< of the taps of output 0, may be negative
  std::int64_t count = 1;    ///< taps
};

/// sum over rank of (taps along the columns) x (taps along the rows): rows first, then columns. x_taps[r], y_taps[r]:
/// the pairs, of x.count and y.count taps.
std::shared_ptr<const Engine> make_separable_engine(const TapAxis& x, const TapAxis& y, Border border,
                                                    std::vector<std::vector<float>> x_taps,
                                                    std::vector<std::vector<float>> y_taps);

/// One two-dimensional kernel, y.count rows of x.count taps; taps that are zero cost nothing.
std::shared_ptr<const Engine> make_direct_engine(const TapAxis& x, const TapAxis& y, Border border,
                                                 std::vector<float> taps);

}  // namespace mtf
