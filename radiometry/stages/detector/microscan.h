// SPDX-License-Identifier: Apache-2.0
#pragma once

// Microscan: the image is moved over the detector by fractions of a pitch, one frame of the detector for each position,
// and the frames are put together to a finer one.
//   square     n x n positions, 1/n of the pitch apart: position k is column k mod n, row k / n of each cell
//   diagonal   2 positions, half a pitch apart in both directions: of each cell of 2 x 2 the places (0, 0) and (1, 1);
//              the other two are the mean of their neighbours to the left, right, above and below
// The image that is taken apart is sampled at pitch / n; its footprint stays that of the pixel. Each frame has its own
// noise and the fixed pattern of the detector. (Fortin and Chevrette, Proc. SPIE 2743, 23 (1996).)

#include <span>

#include "mtf/image.h"
#include "radiometry/fields.h"
#include "radiometry/stages/noise/random.h"

namespace radiometry {

enum class MicroscanPattern { square, diagonal };
inline constexpr std::array<std::string_view, 2> kMicroscanPatternNames{"square", "diagonal"};
constexpr std::span<const std::string_view> words(MicroscanPattern) { return kMicroscanPatternNames; }

struct Microscan {
  int steps = 2;
  MicroscanPattern pattern = MicroscanPattern::square;

  int positions() const { return pattern == MicroscanPattern::diagonal ? 2 : steps * steps; }

  static constexpr auto fields() {
    return std::tuple{
        optional(&Microscan::steps, "steps", 1, 16, "3", "positions in a pitch, per axis; 2 for the diagonal pattern"),
        optional(&Microscan::pattern, "pattern", "\"diagonal\"",
                 "square (steps x steps positions), or diagonal (2 of 2 x 2)")};
  }
};

/// The frame of the detector at position k, from 0 to positions() - 1: every steps-th sample of the fine image. Throws
/// UsageError for values out of their bounds, a diagonal pattern of other than 2 steps, a position that does not exist,
/// and an image that is not a whole number of cells.
mtf::Image microscan_frame(mtf::ImageView<const float> fine, const Microscan& microscan, int position);

/// The fine image of all frames in the order of their positions: the inverse of microscan_frame, but for the places in
/// between of the diagonal pattern. Throws UsageError for another number of frames and for frames of several sizes.
mtf::Image microscan_interlace(std::span<const mtf::Image> frames, const Microscan& microscan);

/// The noise key of the frame at a position of the fine frame `key.frame`: the frames of all positions are numbered
/// consecutively. Throws UsageError for numbers that do not fit into 32 bits.
NoiseKey microscan_key(const NoiseKey& key, const Microscan& microscan, int position);

}  // namespace radiometry
