// SPDX-License-Identifier: Apache-2.0
#pragma once

// The regions of a plane, measured several at once.

#include <optional>
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

}  // namespace apps
