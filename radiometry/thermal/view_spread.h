// SPDX-License-Identifier: Apache-2.0
#pragma once

// How far facets are from the unit that is solved for them, by what they see: the long-wave irradiance of a facet from
// its own view of sky, ground and patches, against that of its unit, on facets spread evenly over the list. Two facets
// that see equal shares of other surfaces may see warmer and colder ones; and the view that decides about units is
// sampled. Both are in this number, and so is the sampling error of the views that are compared. It is measured, not
// bounded.

#include "radiometry/scene/table_error.h"
#include "radiometry/thermal/heat_batches.h"

namespace radiometry::thermal {

/// In K: the largest difference of absorbed long-wave flux over the nodes of the window solved last, over the loss.
struct ViewSpread {
  scene::TableError error_k;
  double largest_k = 0.0;
};

ViewSpread view_spread(const HeatScene& scene, const Units& units, const GroundLight& ground,
                       const HeatBatches& batches, const Window& window, const HeatOptions& options, double loss_w_m2_k,
                       std::size_t count = 2000);

}  // namespace radiometry::thermal
