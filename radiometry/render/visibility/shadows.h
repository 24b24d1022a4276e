// SPDX-License-Identifier: Apache-2.0
#pragma once

// Which parts of samples the sun reaches.

#include "radiometry/render/visibility/sides_in_sun.h"

namespace radiometry::render {

/// Fills `lit` of all parts and runs, and returns the number of shadow rays. Sides that are in the sun as a whole, or
/// in the shadow, take no work; runs on sides in part are divided. Where a side is `unknown`, each part has a ray.
/// With a null `in_sun` every part that faces the sun has. The sides of the parts are among `sides`.
std::size_t find_shadows(const RenderScene& scene, const VisibleSides& sides, const SidesInSun* in_sun,
                         VisibleParts& parts, int threads);

}  // namespace radiometry::render
