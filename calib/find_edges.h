// SPDX-License-Identifier: Apache-2.0
#pragma once

// Regions with a usable edge in an image: charts, tilted squares, knife edges, natural scenes.

#include <string>
#include <vector>

#include "calib/edge_curve.h"
#include "mtf/image.h"

namespace calib {

struct FindOptions {
  std::size_t most = 64;        ///< regions returned
  double min_length_px = 20.0;  ///< of an edge
  double min_cnr = 8.0;         ///< contrast / noise of a pixel
  double half_width_px = 0.0;   ///< wanted on each side of the edge; 0 = as far as the sides stay free, at most 64
};

struct FoundEdge {
  Roi roi;             ///< holds the edge, both sides free of other structure as far as possible
  double score = 0.0;  ///< larger is better: predicted precision of the MTF
};

struct FoundEdges {
  std::vector<FoundEdge> edges;  ///< best first; an image crossed by one edge gives the whole image
  std::string reason;            ///< when there is none: what was seen and what to try
};

/// NaN pixels are no data. Linear in the number of pixels. Deterministic.
FoundEdges find_edges(mtf::ImageView<const float> image, const FindOptions& options = {});

}  // namespace calib
