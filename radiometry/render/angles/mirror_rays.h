// SPDX-License-Identifier: Apache-2.0
#pragma once

// The rays that meet a finish whose emissivity depends on the angle, or that is glossy: at which angle, and where the
// light comes from that a mirror in its place would show,
//   d' = d - 2 (d . n) n,
// one ray from just above the surface. Other finishes cost a look at a list for each ray, and nothing where a scene has
// none of them.

#include "radiometry/render/frame_rays.h"
#include "radiometry/render/render_scene.h"

namespace radiometry::render {

struct MirrorRays {
  std::vector<std::uint32_t> ray{};  ///< index into RayHits
  std::vector<float> relative{};     ///< emissivity there over that along the normal
  RayHits met{};  ///< by mirror rays: side, and the sine of the elevation of those that leave (or have no gloss)

  std::size_t size() const { return ray.size(); }
};

/// Whether any finish asks for them.
bool has_angles(const RenderScene& scene);

/// Of packets [first, first + hits.packets()) of the plan.
MirrorRays mirror_rays(const RenderScene& scene, const Camera& camera, const RayPlan& plan, std::size_t first,
                       const RayHits& hits, int threads);

}  // namespace radiometry::render
