// SPDX-License-Identifier: Apache-2.0
#pragma once

// What the samples of a frame show. A sample has n x n points (screen.h); those of them that show the same side are one
// part of it, and so are those that show none. The place of a part is the mean of its points: on the plane of the facet
// one over the depth is linear in the image, so that its mean over the points is that at this place.

#include <cstdint>
#include <vector>

#include "radiometry/render/path_grid.h"
#include "radiometry/render/visibility/screen.h"

namespace radiometry::render {

struct SamplePart {
  std::uint32_t column = 0, row = 0;  ///< of the sample
  std::uint32_t side = 0;             ///< scene::index(side); kNone where the scene is left
  float range_m = 0.0F;               ///< from the camera; 0 where the scene is left
  float height_m = 0.0F;              ///< of what is seen; where the scene is left, the sine of the elevation
  std::uint16_t points = 0;  ///< bit j * n + i: the point in column i and row j; the first part of a sample has bit 0
  std::uint8_t shown = 0;    ///< number of these points
  bool lit = false;          ///< the sun reaches it, where that was asked
};

/// Bands of whole rows of samples, with their parts in the order of samples.
struct VisibleParts {
  int n = 1;
  std::vector<std::vector<SamplePart>> band{};
  PathExtent extent{};        ///< of what is seen of facets
  std::size_t on_facets = 0;  ///< parts
  std::size_t divided = 0;    ///< samples of more than one part
};

/// Fills `parts`, whose memory is used again. `n` is 1, 2 or 4; `likely` as in screen.h. The result does not depend on
/// `likely` or `threads`.
void find_parts(const RenderScene& scene, const Camera& camera, int n, std::span<const std::uint32_t> likely,
                VisibleParts& parts, int threads);

/// Where a part is, in samples from the outer corner of the image.
struct PlaceInImage {
  double x, y;
};
PlaceInImage place_of(const SamplePart& part, int n);
/// What is seen there, on the plane of the facet in double precision, and the side's normal: where rays start.
struct PlaceInScene {
  Point point;
  Vector normal, direction;  ///< of length 1: from the surface; from the camera
};
PlaceInScene place_of(const RenderScene& scene, const Camera& camera, const SamplePart& part, int n);

}  // namespace radiometry::render
