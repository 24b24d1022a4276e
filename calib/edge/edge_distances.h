// SPDX-License-Identifier: Apache-2.0
#pragma once

// Distances of many pixels from an edge at once, in loops that the compiler can vectorise.

#include <span>

#include "calib/edge/edge_curve.h"

namespace calib {

/// u across and s along the tangent at the curve's origin, in px (edge_curve.h), become distances from the curve and
/// positions of the feet on it. The search for the feet ends with a step below 0.01 px near the edge and 0.5 px where
/// the edge spread function is flat; the error of a distance is of third order in that step.
void bend_all(const EdgeCurve& curve, std::span<double> u_px, std::span<double> s_px);

}  // namespace calib
