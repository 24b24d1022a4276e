// SPDX-License-Identifier: Apache-2.0
#include "radiometry/stages/detector/lag.h"

#include <cmath>

namespace radiometry {

void apply_lag(mtf::ImageView<float> frame, const Lag& lag, double frame_time_s, LagState& state) {
  require_valid("lag", lag);
  if (!(frame_time_s > 0.0))
    throw mtf::UsageError("lag: " + mtf::format_double(frame_time_s) + " s from frame to frame; it has to be above 0");
  const bool first = state.level.empty();
  if (!first && (frame.width != state.width || frame.height != state.height))
    throw mtf::UsageError("lag: a frame of " + size_of(frame.width, frame.height) + " pixels after frames of " +
                          size_of(state.width, state.height) + "; give all one size");
  if (first) {
    state.width = frame.width;
    state.height = frame.height;
    state.level.assign(static_cast<std::size_t>(frame.width) * static_cast<std::size_t>(frame.height), std::nan(""));
  }
  const double share = -std::expm1(-frame_time_s / lag.time_constant_s);
  double* level = state.level.data();
  for (std::int64_t y = 0; y < frame.height; ++y) {
    float* row = frame.row(y);
    for (std::int64_t x = 0; x < frame.width; ++x, ++level) {
      const double now = static_cast<double>(row[x]);
      *level = std::isfinite(*level) ? *level + (now - *level) * share : now;
      row[x] = static_cast<float>(*level);
    }
  }
}

}  // namespace radiometry
