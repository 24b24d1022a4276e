// SPDX-License-Identifier: Apache-2.0
#pragma once

// What the covariance of a fit leaves out: that another shape of the edge would have fitted the pixels as well.

#include "calib/measure/esf_refine.h"
#include "calib/measure/measure.h"
#include "calib/measure/region_fit.h"

namespace calib {

/// Where few distances occur the pixels do not distinguish diffraction, a footprint and a Gaussian, which differ
/// between these distances. Adds the differences from what the result would be with a Gaussian alone, with the
/// footprint of a whole pixel, and with that and diffraction, if these fit, to the standard deviations.
void add_other_shapes(const EdgePixels& pixels, const EdgeFit& fit, const EdgeFacts& facts, FitSettings settings,
                      EdgeMeasurement& measurement);

/// Much noise in few pixels leaves errors for which the response is not linear in its shape: an edge that comes out too
/// blurred has too small a standard deviation, as the MTF depends little on a wide blur. The standard deviations become
/// no smaller than those at the upper end of the interval of the MTF at Nyquist, the end being that from which the
/// result lies 1.96 of the deviations there away, and than 1 / 1.96 of the distance of that end.
void add_sharper_end(const EdgePixels& pixels, const CorrectedFit& corrected, const EdgeFacts& facts,
                     FitSettings settings, EdgeMeasurement& measurement);

}  // namespace calib
