// SPDX-License-Identifier: Apache-2.0
#pragma once

// The level that is taken off a plane before it is filtered, so that rounding counts contrast and not brightness, and
// the scale that keeps what is left within the range of float. Any level near the mean does: one that samples at 64
// places tell is enough for those that check it as they read, and saves them a look at the whole plane.

#include <optional>

#include "mtf/engines/engine.h"
#include "mtf/engines/kernels.h"
#include "mtf/plan/border.h"
#include "mtf/survey/uniform_runs.h"

namespace mtf {

struct MeanAndDeviation {
  double mean = 0.0;       ///< to float: taken off a float, it leaves one rounding of the difference
  double deviation = 0.0;  ///< largest |value - mean|; 0: the plane is of one level
};

/// Of samples at 8 x 8 places; nothing where they are of one level or not finite.
std::optional<MeanAndDeviation> sampled_mean_and_deviation(ImageView<const float> plane);

/// Of all samples, summed row by row in a fixed order. The same look tells where the plane is flat, while its rows are
/// at hand. Throws RuntimeError for pixels that are NaN or infinite, with their number and first position.
MeanAndDeviation mean_and_deviation(ImageView<const float> plane, int threads, UniformRuns& flat);

/// Largest |value - mean| of a plane's canvas.
double canvas_deviation(const MeanAndDeviation& level, Border border, double border_value);

/// A power of two that takes `deviation` to about 1; it and its inverse are floats themselves.
double scale_for(double deviation);

/// Standard deviation of samples of these moments.
double std_of(const kernels::Moments& moments, std::int64_t samples);

/// Whether a level that few samples gave does for all of them, whose moments about it are these: it is no further from
/// the mean than a quarter of the standard deviation, and all are finite, also in this scale. Rounding counts the rms
/// of the canvas about the level: 3 % more, and at most a quarter more where a border's level is not the image's mean.
bool is_near(const kernels::Moments& moments, std::int64_t samples);

/// The channel at the level of all samples, as mean_and_deviation gives it.
Channel recentred(Channel channel, Border border, int threads);

}  // namespace mtf
