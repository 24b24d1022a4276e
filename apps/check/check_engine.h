// SPDX-License-Identifier: Apache-2.0
#pragma once

// One plan against slow sums in double.

#include "apps/check/check.h"
#include "apps/check/reference_image.h"

namespace apps::check {

/// A detector of pitch 15 x 12 um with a radial, a separable and a complex factor of the OTF.
mtf::System<double> optics();

/// Noise of that mean and standard deviation, the same on every machine.
mtf::Image noisy(std::int64_t width, std::int64_t height, double mean = 0.0, double std = 1.0);

/// Filters `scene`, `ratio` samples a pixel, and compares with `exact`, the presample OTF of the system: the rms error
/// relative to the scene's standard deviation may be what the plan predicted. Uniform scenes are skipped, and what the
/// device of the tally cannot do.
void keeps_promise(Tally& tally, const mtf::System<double>& system, const mtf::Image& scene, double ratio,
                   mtf::Border border, const Otf& exact);

}  // namespace apps::check
