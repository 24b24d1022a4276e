// SPDX-License-Identifier: Apache-2.0
#pragma once

// How much light rims of lenses leave off the axis: the share of the area of the pupil of the component wavefront
// (vignetting_rim) at the field point of each pixel. Its OTF is normalised without it, so this factor applies once.

#include "mtf/image.h"
#include "mtf/system.h"

namespace mtf {

/// One share, 0 to 1, for each pixel of the detector of frame.format. Throws UsageError where that is not given, and
/// where no wavefront of the presample list has a rim.
Image throughput_image(const System<double>& system, int threads = 1);

}  // namespace mtf
