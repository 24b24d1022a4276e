// SPDX-License-Identifier: Apache-2.0
#pragma once

// Planes beside the radiance of a frame, from what its rays met.

#include "radiometry/render/renderer.h"

namespace radiometry::render {

struct LayerInputs {
  const RenderScene& scene;
  const Camera& camera;
  const RayHits& hits;  ///< of RayPlan::tiles
  const MirrorRays& mirrors;
  const VisibleSides& sides;
  const BandShader& shader;
  const BandShader* surface;           ///< the same band without air; null where neither layer asks for it
  const std::vector<float>& radiance;  ///< of the rays
  const LayerChoice& choice;
  int threads;
};

/// Names are those of OpenEXR channels: temperature, emissivity, Z, facet, material, normal.X, surface ...
std::vector<NamedLayer> layers_of(const LayerInputs& inputs);

/// Values of the rays of RayPlan::tiles as an image.
mtf::Image image_of(const Camera& camera, const std::vector<float>& of_rays, int threads);

}  // namespace radiometry::render
