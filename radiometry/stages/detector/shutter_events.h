// SPDX-License-Identifier: Apache-2.0
#pragma once

// The shutter of a thermal camera over a sequence. It closes at frame 0 and in regular intervals after it; what the
// pixels give then is taken off the frames up to the next closing. Between two closings the camera gets warmer at a
// constant rate, and shutter, housing and optics with it:
//   T(n) = T(0) + drift n T_frame                      of frame n
//   frame n = open camera at T(n) - closed camera at T(m),   m = the last closing, at frame n or before it
// So frames between closings have a false offset, that of what the housing and the optics have warmed since then, and
// each closing takes it away. It does not take away that the shutter itself is warmer: the same scene gives less after
// it, as the signal is the difference to the shutter. (Nugent, Shaw and Pust, Opt. Eng. 52, 061304 (2013): drift of
// microbolometer cameras with their temperature. Signals of the open and the closed camera: light/signal.h.)

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "radiometry/light/spectral_signal.h"

namespace radiometry {

struct ShutterEvents {
  double drift_k_s = 0.0;
  double frame_time_s = 0.0;
  std::uint32_t interval = 1;  ///< frames from one closing to the next

  std::uint32_t closing_before(std::uint32_t frame) const { return frame - frame % interval; }
  double warming_k(std::uint32_t frame) const { return drift_k_s * frame_time_s * frame; }
};

/// Frames in an interval, at least one.
inline std::uint32_t interval_frames(double interval_s, double frame_time_s) {
  return static_cast<std::uint32_t>(std::clamp(std::round(interval_s / frame_time_s), 1.0, 1e9));
}

/// A camera that is so much warmer: all of it that emits at all.
inline CameraEmission warmed(CameraEmission camera, double by_k) {
  for (double* temperature_k : {&camera.optics_k, &camera.stop_k, &camera.shutter_k})
    if (*temperature_k > 0.0) *temperature_k = std::max(*temperature_k + by_k, 0.0);
  return camera;
}

/// The last closing that a frame of a sequence knows of.
struct ShutterClosing {
  std::uint32_t frame = 0;
  CameraEmission camera;
};

}  // namespace radiometry
