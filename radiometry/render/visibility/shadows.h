// SPDX-License-Identifier: Apache-2.0
#pragma once

// Which parts of samples the sun reaches.

#include "radiometry/render/visibility/sides_in_sun.h"

namespace radiometry::render {

/// Fills `lit` of all parts and runs, and returns the number of shadow rays. Sides that are in the sun as a whole, or
/// in the shadow, need none; runs on other ones are turned into parts. From what is left one ray goes from each square
/// of 2 x 2 samples; where its answer is not that of the squares around it, where one of those asks nothing, or where
/// bodies that do not touch show in it, all parts in it have rays of their own. With a null `in_sun` every part that
/// faces the sun has. A shadow that is smaller than 2 x 2 samples shows where a ray meets it. The sides of the parts
/// are among `sides`.
std::size_t find_shadows(const RenderScene& scene, const VisibleSides& sides, const SidesInSun* in_sun,
                         VisibleParts& parts, int threads);

}  // namespace radiometry::render
