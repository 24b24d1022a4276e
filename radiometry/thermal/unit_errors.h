// SPDX-License-Identifier: Apache-2.0
#pragma once

// What solving units in place of facets leaves open, measured in the first day: neither is bounded, nor part of the
// promise.
//
// View spread: how far facets are from the unit that is solved for them, by what they see: the long-wave irradiance of
// a facet from its own view of sky, ground and patches, against that of its unit, on facets spread evenly over the
// list. Two facets that see equal shares of other surfaces may see warmer and colder ones; and the view that decides
// about units is sampled. Both are in this number, and so is the sampling error of the views that are compared.
//
// Left out: what is not solved where only facets that the camera sees are asked for (HeatOptions::seen): units that it
// does not see, but for some of each patch (facet_units.h). What such a patch emits is the mean of those,
//   M = sum_i w_i e_i,   w_i the share of the area that they have,   e_i = eps sigma T_i^4,
// with the variance V = n / (n - 1) sum_i w_i^2 (e_i - M)^2 (1 - n / N) of a ratio of means (Cochran, Sampling
// Techniques, 1977, section 6.3) for n of N units. A surface gets F_p of it from patch p, so that its absorbed flux has
// the standard error eps sqrt(sum_p F_p^2 V_p), patches being independent of each other. Units are taken evenly along
// the order of their shadows, which makes the true error smaller than that of units taken at random.

#include "radiometry/scene/table_error.h"
#include "radiometry/thermal/heat_batches.h"

namespace radiometry::thermal {

/// In K: the largest difference of absorbed long-wave flux over the nodes of the window solved last, over the loss.
struct ViewSpread {
  scene::TableError error_k;
  double largest_k = 0.0;
};

ViewSpread view_spread(const HeatScene& scene, const Units& units, const GroundLight& ground,
                       const HeatBatches& batches, const Window& window, const HeatOptions& options,
                       double loss_w_m2_k);

/// How much is left out, and by how much that changes the temperatures of units that are seen: the standard error in K
/// at the hour where it is largest.
struct LeftOut {
  std::size_t facets = 0;  ///< not seen
  std::size_t units = 0;   ///< not solved
  scene::TableError error_k;
  double largest_k = 0.0;
};

/// Over the nodes of the window solved last, an hour apart.
LeftOut left_out(const HeatScene& scene, const Units& units, const HeatBatches& batches, const Window& window,
                 double loss_w_m2_k, int threads);

}  // namespace radiometry::thermal
