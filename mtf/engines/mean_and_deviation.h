// SPDX-License-Identifier: Apache-2.0
#pragma once

// The mean that is subtracted from a plane before it is filtered, so that rounding is relative to the contrast and not
// to the brightness, and the scale that keeps the difference within the range of float. Any value near the mean serves.
// The mean of samples at 64 places is enough for an engine that checks it while it reads the plane, and saves a pass.

#include <optional>

#include "mtf/border.h"
#include "mtf/engines/engine.h"
#include "mtf/engines/kernels.h"
#include "mtf/engines/uniform_runs.h"

namespace mtf {

struct MeanAndDeviation {
  double mean = 0.0;       ///< rounded to float, so that a float less the mean is rounded once
  double deviation = 0.0;  ///< largest |value - mean|; 0 where the plane is uniform
};

/// From samples at 8 x 8 places; nothing where all of these are equal or one is not finite.
std::optional<MeanAndDeviation> sampled_mean_and_deviation(ImageView<const float> plane);

/// From all samples, summed row by row in a fixed order. The same pass over the plane finds its uniform runs, `flat`.
/// Throws RuntimeError for pixels that are NaN or infinite, with their number and first position.
MeanAndDeviation mean_and_deviation(ImageView<const float> plane, int threads, UniformRuns& flat);

/// Largest |value - mean| on the canvas of a plane.
double canvas_deviation(const MeanAndDeviation& plane, Border border, double border_value);

/// The power of two that brings `deviation` to about 1; it and its inverse are floats.
double scale_for(double deviation);

/// Standard deviation of samples with these moments.
double std_of(const kernels::Moments& moments, std::int64_t samples);

/// Whether an estimate of the mean and its scale serve for all samples, whose moments about the estimate are given: all
/// samples are finite in this scale, and the estimate is no further from the mean than a quarter of the standard
/// deviation. Rounding is relative to the rms of the canvas about the estimate, which is then 3 % larger than about the
/// mean, and at most a quarter larger where the value of a constant border is not the image's mean.
bool is_near(const kernels::Moments& moments, std::int64_t samples);

/// The channel with the mean and scale of all samples, as mean_and_deviation gives them.
Channel recentred(Channel channel, Border border, int threads);

}  // namespace mtf
