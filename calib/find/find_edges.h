// SPDX-License-Identifier: Apache-2.0
#pragma once

// Regions with a usable edge in an image: charts, tilted squares, checkerboards, knife edges, natural scenes.
// 1. Pixels are averaged in cells (of one pixel, of two where most are masked, of more above 2^24 cells), smoothed by
//    binomials that leave masked cells and single hot, dead or wild pixels out, and differentiated. Gradients above 6
//    standard deviations of the noise count; the noise is the median second difference along both axes.
// 2. From the largest gradients down, connected cells whose directions agree within 22.5 degrees make a ridge;
//    it is cut where it leaves a parabola, so that gently curved edges stay whole and corners end them.
// 3. Along the normals of a piece the gradient has to fall to a share (5, 10 or 20 %) of its peak on both sides,
//    which is where the blur ends. Beyond it nothing above that share may lie: an integral image counts what is in a
//    rectangle and does not belong to the edge, and two ends that follow each other along the edge find the longest
//    free rectangle for each of nine half widths.
// 4. The score is (contrast / noise) sqrt(length), to which the precision of an MTF is proportional, less where the
// sides are
//    short against the blur, and less for the larger shares.
// No piece is rejected for its place in the image or for the number of others: one without a plateau on both sides is
// dropped at once, and only where the others exceed the memory allowed are those of least score dropped too.
// Sources: R. Grompone von Gioi et al., LSD: a line segment detector, IPOL 2, 35 (2012) for growing; J. Immerkaer, Fast
// noise variance estimation, CVIU 64, 300 (1996) for the noise.

#include <string>
#include <vector>

#include "calib/edge/edge_curve.h"
#include "mtf/image.h"

namespace calib {

struct FindOptions {
  std::size_t most = 64;        ///< regions returned
  double min_length_px = 20.0;  ///< of an edge
  double min_cnr = 8.0;         ///< contrast / noise of a pixel
  /// Width of the region on each side of the edge, less where the sides are not free. 0: the best score, up to 64.
  double half_width_px = 0.0;
  /// Pieces with a plateau on both sides that are held at a time: at most 100 MiB.
  std::size_t most_pieces = std::size_t{1} << 18;
};

struct FoundEdge {
  Roi roi;             ///< holds the edge, both sides free of other structure as far as possible
  double score = 0.0;  ///< larger is better: predicted precision of the MTF
};

struct FoundEdges {
  std::vector<FoundEdge> edges;  ///< best first; an image crossed by one edge gives the whole image
  std::string reason;            ///< when there is none: what was seen and what to try
  std::size_t left_out = 0;      ///< usable regions beyond `most`: those of least score
  std::size_t not_tried = 0;     ///< pieces beyond `most_pieces`: those that could score least
};

/// NaN pixels are no data, whatever their share: masks and Bayer planes. Takes time in proportion to the pixels and
/// memory for at most 2^24 cells (about 200 MiB) and `most_pieces`. Deterministic. Data never throw: without a region
/// the reason names what was found. Throws UsageError for options that are not positive.
FoundEdges find_edges(mtf::ImageView<const float> image, const FindOptions& options = {});

}  // namespace calib
