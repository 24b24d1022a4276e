// SPDX-License-Identifier: Apache-2.0
#pragma once

// The parts of samples that show a finish whose emissivity depends on the angle, or that is glossy: at which angle, and
// where the light comes from that a mirror in its place would show,
//   d' = d - 2 (d . n) n,
// one ray from just above the surface. Other finishes cost a look at a list for each part, and nothing where a scene
// has none of them.

#include "radiometry/render/visibility/visible_parts.h"

namespace radiometry::render {

struct MirrorRays {
  struct Place {
    std::uint32_t band, part;
  };
  std::vector<Place> of{};            ///< which part of VisibleParts
  std::vector<float> relative{};      ///< emissivity there over that along the normal
  std::vector<std::uint32_t> side{};  ///< that the mirror shows; kNone where its ray leaves, or has no gloss
  std::vector<float> rise{};          ///< sine of the elevation of that ray

  std::size_t size() const { return of.size(); }
};

bool has_angles(const Finish& finish);
/// Whether any finish asks for them.
bool has_angles(const RenderScene& scene);

MirrorRays mirror_rays(const RenderScene& scene, const Camera& camera, const VisibleParts& parts, int threads);

}  // namespace radiometry::render
