// SPDX-License-Identifier: Apache-2.0
#pragma once

// The regions of a plane, measured several at once.

#include <optional>
#include <span>
#include <vector>

#include "apps/edges/edge_input.h"
#include "apps/edges/measure_report.h"

namespace apps {

struct EdgeMethod {
  std::optional<int> order;  ///< of the edge curve
  bool circle = false;
  MeasureMethod method = MeasureMethod::regression;
};

/// One result a region, in their order; a region that leaves the image has that as its outcome. A plane without regions
/// gives one result, that no edge was found.
std::vector<MeasuredEdge> measure_plane(const EdgePlane& plane, const EdgeMethod& method, int threads);

// Lateral colour: how far the edge of one plane of an image lies from the same edge in another plane. Magnification
// that depends on the wavelength, a prism error or planes that are out of register shift an edge along its normal.
//
// An edge is the same in both planes where the normals agree within 2 degrees, and where its middle lies beside the
// other one, at most 5 pixels away. The location is the one about which the phase of the OTF is least (EdgeMeasurement,
// calib/measure/measure.h), so that a displacement comes out whole; an asymmetric blur (coma) of one plane alone counts
// as a displacement in part.

/// Sets `shift` of the measured edges of one image, planes of which follow one another. The reference is the green
/// plane (a name whose last part begins with G), else the first; its own edges have no shift, nor have edges without a
/// partner there.
void add_lateral_shifts(std::span<MeasuredEdge> edges);

}  // namespace apps
