// SPDX-License-Identifier: Apache-2.0
#pragma once

// Lag of a camera from successive frames between two of which the light steps from one level to another. As [lag] of a
// sensor file has it (radiometry/stages/detector/lag.h) the mean of frame k = 1, 2 ... after the step is
//   y = B + (A - B) r^k,   r = exp(-frame time / time constant)
// A is the mean of the frames before, B and r follow from those after it by least squares. Their errors are those of
// the scatter of frames before the step and of the residuals after it, with the correlation of successive ones, which
// blinking pixels and 1/f noise make, and the noise of the light of which the first frames have a part; limits by
// Student's t. Frames of another course, as after a step within an
// exposure, or with two time constants, have residuals larger than the differences of successive frames late after the
// step make (F). Light that fades looks as lag does: a shutter steps, a lamp does not.

#include "calib/characterize/characterize.h"

namespace calib {

inline constexpr std::ptrdiff_t kBeforeStep = 8, kAfterStep = 16;  ///< least numbers of frames

struct LagStep {
  double before = 0.0;         ///< A
  Estimate after, kept;        ///< B; r, the part of a step that the first frame after it lacks
  double dof = 1.0;            ///< of the errors
  bool is_exponential = true;  ///< the residuals are noise
};

/// Of the means of frames. Throws UsageError, naming the remedy, for fewer frames on either side of the step, and for
/// none: the largest difference of successive frames is below ten times the noise.
LagStep fit_lag_step(const std::vector<double>& means);

/// lag_share, and lag_time_constant where it is determined, of frames that far apart. `from`: the frames' name.
void add_lag(const LagStep& step, double frame_time_s, const std::string& from, Characterization& camera);

}  // namespace calib
