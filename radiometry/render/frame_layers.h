// SPDX-License-Identifier: Apache-2.0
#pragma once

// Planes beside the radiance of a frame, of the middle of each sample.

#include "radiometry/render/renderer.h"

namespace radiometry::render {

struct LayerInputs {
  const RenderScene& scene;
  const Camera& camera;
  const VisibleParts& middles;  ///< n = 1
  const MirrorRays& mirrors;    ///< of them
  const VisibleSides& sides;
  const BandShader& shader;
  const BandShader* surface;   ///< the same band without air; null where neither layer asks for it
  const mtf::Image& radiance;  ///< of the middles
  const LayerChoice& choice;
  bool shadows;  ///< SamplePart::lit is known
  int threads;
};

/// Names are those of OpenEXR channels: temperature, emissivity, Z, facet, material, normal.X, surface ...
std::vector<NamedLayer> layers_of(const LayerInputs& inputs);

}  // namespace radiometry::render
