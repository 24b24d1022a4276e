// SPDX-License-Identifier: Apache-2.0
#pragma once

// Edges beside the region, along the edge that is measured: their tails of diffraction extend into it. A step by c at
// the distance x adds 2 S c / (pi^3 (x - d)) at the distance d, several thousandths of its contrast 20 px away, which
// neither plateaus nor gradients describe and which would be taken for part of the contrast. Where these edges are and
// how large they are is read from the image beyond the region: from the mean of its pixels by distance. S is that of
// the fit; nothing else is unknown. Structure that crosses the normal obliquely counts with its mean.

#include <vector>

#include "calib/edge/edge_pixels.h"
#include "calib/measure/edge_sums.h"

namespace calib {

struct Neighbours {
  std::vector<double> tails;  ///< by bin, what they add to a pixel per S, in units of EdgePixels::value; empty: nothing
  double nearest_px = 0.0;    ///< distance of the nearest one from the edge
};
/// `start` is in the coordinates of the region's pixels; structure below 5 % of its contrast does not count.
Neighbours find_neighbours(mtf::ImageView<const float> image, const Roi& roi, const RegionFacts& region,
                           const EdgeModel& start);

}  // namespace calib
