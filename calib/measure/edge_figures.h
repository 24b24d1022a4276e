// SPDX-License-Identifier: Apache-2.0
#pragma once

// Curves and figures of merit of an edge's response, each with its standard deviation.

#include "calib/edge/edge_response.h"
#include "calib/measure/measure.h"

namespace calib {

/// Fills the curves and the figures from mtf10 to sampling_efficiency; what is not there is named in `absent`.
void describe(const EdgeResponse& response, EdgeMeasurement& measurement);

/// Adds the difference from what another shape that fits as well gives to the standard deviations.
void hold_difference(const EdgeMeasurement& other, EdgeMeasurement& measurement);

}  // namespace calib
