// SPDX-License-Identifier: Apache-2.0
#pragma once

// What the samples of a frame show. A sample has n x n points (screen.h); those of them that show the same side are one
// part of it, and so are those that show none. The place of a part is the mean of its points: on the plane of the facet
// one over the depth is linear in the image, so that its mean over the points is that at this place.
//
// Whole samples of one side next to each other are a run, of which one value in the first and its slope say where all
// of them are: a picture is mostly runs, and loops over them have no branches.

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

/// Samples of a row that show the same side in all of their points.
struct SampleRun {
  std::uint32_t column = 0, row = 0;  ///< of the first
  std::uint32_t samples = 0;
  std::uint32_t side = 0;              ///< scene::index(side)
  float nearness = 0.0F, step = 0.0F;  ///< one over the depth of the first, and how much it grows from one to the next
  bool lit = false;                    ///< the sun reaches all of them, where that was asked
};
/// One of them, as a part.
SamplePart sample_of(const SampleRun& run, std::uint32_t number, const Camera& camera, int n);

/// Bands of whole rows of samples. Parts of one sample come one after the other.
struct VisibleParts {
  Camera camera{};
  int n = 1;
  std::vector<std::vector<SamplePart>> band{};
  std::vector<std::vector<SampleRun>> runs{};  ///< of each band
  PathExtent extent{};                         ///< of what is seen of facets
  std::size_t on_facets = 0;                   ///< parts, and samples of runs
  std::size_t divided = 0;                     ///< samples of more than one part
};

struct PartsOptions {
  int n = 2;         ///< points along a sample: 1, 2 or 4
  bool runs = true;  ///< false: every sample has parts. Sides whose radiance depends on the angle always have.
  std::span<const std::uint32_t> likely{};  ///< as in screen.h
  int threads = 0;
};
/// Fills `parts`; the memory of `screen` and `parts` is used again. What is seen does not depend on `runs`, `likely`
/// and `threads`; the nearest range of `extent` is a lower bound where there are runs.
void find_parts(const RenderScene& scene, const Camera& camera, const PartsOptions& options, Screen& screen,
                VisibleParts& parts);

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
