// SPDX-License-Identifier: Apache-2.0
#pragma once

// Walls of closed shells, inside.kind = "pair": heat passes from a facet through the layers to the opposite facet,
// whose sun, sky, surroundings and wind are those of the other end. Every facet has a column of its own, of which its
// own end is its temperature; the column of the facet opposite has the other. Facets without an opposite one within the
// distance, as at the rims of a plate, are solved as adiabatic inside, and counted.

#include "radiometry/thermal/heat_scene.h"

namespace radiometry::thermal {

/// Sets scene.opposite, and puts an adiabatic twin of each pair's material at the end of scene.material. Facets of
/// another material and of given temperature are no opposite ones.
void pair_walls(HeatScene& scene, int threads);

/// The place of the twin of a material, which has pairs.
std::size_t adiabatic_twin(const HeatScene& scene, std::size_t material);

}  // namespace radiometry::thermal
