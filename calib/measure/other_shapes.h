// SPDX-License-Identifier: Apache-2.0
#pragma once

// Where few distances occur the pixels do not distinguish diffraction, a footprint and a Gaussian, which differ between
// these distances. What the result would be with a Gaussian alone, with the footprint of a
// whole pixel, and with that and diffraction, if these fit, is then part of its standard deviation.

#include "calib/measure/measure.h"
#include "calib/measure/region_fit.h"

namespace calib {

/// Adds the differences of the results of these shapes to the standard deviations of the measurement.
void add_other_shapes(const EdgePixels& pixels, const EdgeFit& fit, const EdgeFacts& facts, FitSettings settings,
                      EdgeMeasurement& measurement);

}  // namespace calib
