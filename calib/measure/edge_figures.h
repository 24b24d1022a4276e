// SPDX-License-Identifier: Apache-2.0
#pragma once

// Curves and figures of merit of an edge's response, each with its standard deviation.

#include "calib/edge/edge_pixels.h"
#include "calib/measure/correction/edge_response.h"
#include "calib/measure/measure.h"

namespace calib {

/// Fills the curves and the figures from mtf10 to sampling_efficiency; `absent` names what cannot be determined.
void describe(const EdgeResponse& response, EdgeMeasurement& measurement);

/// Adds the difference from the result of another shape that fits as well to the standard deviations.
void add_difference(const EdgeMeasurement& other, EdgeMeasurement& measurement);

/// Gives every figure the larger of its standard deviation and the one of another result, and no smaller than the
/// distance from that result, at the end of a 95 % interval, allows.
void widen_to_end(const EdgeMeasurement& end, EdgeMeasurement& measurement);

/// The edge's curve, length, sagitta and angle.
void describe_geometry(const EdgeModel& model, const JointFit& joint, const RegionFacts& region,
                       EdgeMeasurement& measurement);

/// Dark and bright value, noise and contrast / noise.
void describe_plateaus(const EdgeModel& model, const NoiseModel& noise, const RegionFacts& region,
                       EdgeMeasurement& measurement);

}  // namespace calib
