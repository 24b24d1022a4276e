// SPDX-License-Identifier: Apache-2.0
#pragma once

// Thermal time constant of a bolometer over a sequence of frames.
//   y_n = y_(n-1) + (x_n - y_(n-1)) (1 - exp(-T / tau))
// x = what the pixel would show in the steady state, T = time from frame to frame, tau = time constant. This is exact
// for a scene that is constant during each frame time: a step is followed as 1 - exp(-t / tau). The first frame is in
// the steady state. The `bolometer` component is the same lag under an image that moves steadily, with its whole past
// in one frame: both together count it twice where the frames show that motion. (Kruse, Uncooled Thermal Imaging,
// ch. 2.)

#include <cstdint>
#include <vector>

#include "mtf/image.h"
#include "radiometry/fields.h"

namespace radiometry {

struct Lag {
  double time_constant_s = 0.01;

  static constexpr auto fields() {
    return std::tuple{above(required(&Lag::time_constant_s, "time_constant", "s", 0.0, 1e6, "\"10 ms\"",
                                     "thermal time constant of a pixel"))};
  }
};

/// What the pixels of one region remember; a new one remembers no frame. The values are double, so that small changes
/// of slow pixels add up.
struct LagState {
  std::int64_t width = 0, height = 0;
  std::vector<double> level;
};

/// Replaces a frame by what the pixels show of it and remembers that. A pixel that was NaN starts anew. Throws
/// UsageError for values out of their bounds, a frame time that is not above 0, and a frame of another size than those
/// before.
void apply_lag(mtf::ImageView<float> frame, const Lag& lag, double frame_time_s, LagState& state);

}  // namespace radiometry
