// SPDX-License-Identifier: Apache-2.0
#pragma once

// Which parts of samples the sun reaches.

#include "radiometry/render/visible_sides.h"

namespace radiometry::render {

/// Fills `lit` of the parts that face the sun, and returns the number of shadow rays. One ray goes from each square of
/// 2 x 2 samples; where its answer is not that of the squares around it, or bodies that do not touch show in it, all
/// parts in it have rays of their own. With
/// `all` every part has. A shadow that is smaller than 2 x 2 samples shows where a ray meets it.
/// The sides of the parts are among `sides`.
std::size_t find_shadows(const RenderScene& scene, const Camera& camera, const VisibleSides& sides, VisibleParts& parts,
                         bool all, int threads);

}  // namespace radiometry::render
